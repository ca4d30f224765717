"""Calibration boards: a checkerboard or a ChArUco board, described by ``board.toml``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.errors import InputError, did_you_mean
from pawnb.files import read_toml
from pawnb.schema.arguments import checked_arguments

_FIELDS = ("board_x", "board_y", "square_length", "marker_length", "marker_bits", "dict_size")
_MARKER_BITS = (4, 5, 6, 7)
_DICTIONARY_SIZES = (50, 100, 250, 1000)
FEWEST_SQUARES, MOST_SQUARES = 3, 100


@dataclass(frozen=True, kw_only=True)
class Board:
    """A calibration board.

    Parameters
    ----------
    columns, rows : int
        Squares along both sides, black and white ones.
    square : float
        Side of a square, in the unit that the calibration will have.
    marker : float, optional
        Side of a marker of a ChArUco board, in the same unit; without it the board is a plain
        checkerboard.
    marker_bits : int
        Black and white cells along the side of a marker: 4 to 7.
    dictionary_size : int
        Markers in the dictionary of OpenCV that it was made with: 50, 100, 250 or 1000.

    Raises
    ------
    InputError
        If these do not make a board.

    Examples
    --------
    >>> board = pawnb.io.Board(columns=8, rows=11, square=24.0, marker=18.75)
    >>> board.corners().shape
    (70, 3)
    """

    columns: int
    rows: int
    square: float
    marker: float | None = None
    marker_bits: int = 4
    dictionary_size: int = 1000

    def __post_init__(self) -> None:
        for name, value in (("board_x", self.columns), ("board_y", self.rows)):
            if not (_whole(value) and FEWEST_SQUARES <= value <= MOST_SQUARES):
                raise InputError(
                    f"{name} is {value!r}; expected the number of squares along that side, "
                    f"{FEWEST_SQUARES} to {MOST_SQUARES}."
                )
        if not _length(self.square):
            raise InputError(
                f"square_length is {self.square!r}; expected one number above 0: all squares of a "
                "board are of one size, as high as they are wide."
            )
        if self.marker is None:
            return
        if not (_length(self.marker) and self.marker < self.square):
            raise InputError(
                f"marker_length is {self.marker!r}; expected a number above 0 and below the side "
                f"of a square, {self.square:g}."
            )
        for name, value, known in (
            ("marker_bits", self.marker_bits, _MARKER_BITS),
            ("dict_size", self.dictionary_size, _DICTIONARY_SIZES),
        ):
            if value not in known:
                raise InputError(f"{name} is {value!r}; expected {', '.join(map(str, known))}.")

    @property
    def shape(self) -> tuple[int, int]:
        """Inner corners along both sides."""
        return self.columns - 1, self.rows - 1

    def corners(self) -> FloatArray:
        """Return where the inner corners are on the board.

        Returns
        -------
        ndarray, shape (n_corners, 3)
            Row by row from the top left; x to the right, y up, z towards who looks at it, in the
            unit of ``square``. The lower left corner of the board is the origin.
        """
        column, row = np.meshgrid(np.arange(1, self.columns), np.arange(1, self.rows))
        xyz = np.stack([column, self.rows - row, np.zeros_like(row)], axis=-1)
        return self.square * xyz.reshape(-1, 3).astype(float)


@checked_arguments
def read_board(path: str | Path) -> Board:
    """Read ``board.toml``.

    Parameters
    ----------
    path : str or Path
        A file with ``board_x``, ``board_y`` (squares along both sides) and ``square_length``; of a
        ChArUco board also ``marker_length``, ``marker_bits`` and ``dict_size``, as sleap-anipose
        names them.

    Returns
    -------
    Board
        The board.

    Raises
    ------
    InputError
        If the file cannot be read, a field is missing or unknown, or it describes no board.

    Examples
    --------
    >>> lines = ["board_x = 8", "board_y = 11", "square_length = 24.0"]
    >>> _ = Path("board.toml").write_text(chr(10).join(lines))
    >>> pawnb.io.read_board("board.toml").shape
    (7, 10)
    """
    path = Path(path)
    expected = "a board.toml with board_x, board_y, square_length, and marker_length of a ChArUco"
    found = read_toml(path, expected=expected)
    for name in found:
        if name not in _FIELDS:
            raise InputError(
                f"{path.name}: unknown field {name!r}{did_you_mean(name, _FIELDS)}; known are "
                f"{', '.join(_FIELDS)}."
            )
    for name in _FIELDS[:3]:
        if name not in found:
            raise InputError(f"{path.name}: {name} is missing; expected {expected}.")
    try:
        return Board(
            columns=found["board_x"],
            rows=found["board_y"],
            square=found["square_length"],
            marker=found.get("marker_length"),
            marker_bits=found.get("marker_bits", 4),
            dictionary_size=found.get("dict_size", 1000),
        )
    except InputError as error:
        raise InputError(f"{path.name}: {error}") from None


def _whole(value: Any) -> bool:
    """Say whether a value is a whole number."""
    return isinstance(value, int) and not isinstance(value, bool)


def _length(value: Any) -> bool:
    """Say whether a value is a length."""
    return (
        isinstance(value, int | float)
        and not isinstance(value, bool)
        and bool(np.isfinite(value))
        and value > 0
    )
