"""Where the inner corners of a calibration board are in a picture."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np

from pawnb.arrays import ByteArray, FloatArray
from pawnb.io.boards import FEWEST_SQUARES, MOST_SQUARES, Board

FEWEST_CORNERS = 6
"""Corners of a shot below which it says too little about a view."""


class CornerFinder:
    """Finds the corners of one board.

    Parameters
    ----------
    board : Board
        The board.
    """

    def __init__(self, board: Board) -> None:
        self.board = board
        self.n_corners = len(board.corners())
        self._detectors: tuple[cv2.aruco.CharucoDetector, ...] = ()
        self._shift = np.zeros(2)
        self._sides: list[float] = []
        if board.marker is not None:
            self._detectors = _detectors(board, board.marker)
            self._shift = _pixel_origin(board, self._detectors[0])

    @property
    def may_be_turned(self) -> bool:
        """Whether the corners may be counted from the other end: a checkerboard has no marks."""
        return self.board.marker is None

    def find(self, grey: ByteArray) -> FloatArray:
        """Find the corners in one picture.

        Parameters
        ----------
        grey : ndarray of uint8, shape (H, W)
            The picture as filmed.

        Returns
        -------
        ndarray, shape (n_corners, 2)
            u and v in px, in the order of :meth:`pawnb.io.boards.Board.corners`; NaN where a
            corner, or the board, is not found.
        """
        uv = np.full((self.n_corners, 2), np.nan)
        if self.board.marker is None:
            found = _checkerboard(grey, self.board.shape)
            return uv if found is None else found
        sides: FloatArray = np.zeros(0)
        for detector in self._detectors:
            corners, ids, markers, _ = detector.detectBoard(grey)
            if ids is not None and len(ids) >= max(FEWEST_CORNERS, np.isfinite(uv[:, 0]).sum() + 1):
                uv[:] = np.nan
                uv[np.ravel(ids)] = np.reshape(corners, (-1, 2)) - self._shift
                sides = _sides_on_board(self.board, uv, np.reshape(markers, (-1, 4, 2)))
        self._sides.extend(sides.tolist())
        return uv

    def marker_side(self) -> float:
        """Return how long the sides of markers were in all pictures, by the squares; else NaN."""
        return float(np.median(self._sides)) if self._sides else np.nan


def other_boards(board: Board) -> list[Board]:
    """Return boards that a person may have meant, the likeliest first.

    Parameters
    ----------
    board : Board
        The board as described.

    Returns
    -------
    list of Board
        Of one more square along both sides (inner corners were counted), along one, then fewer;
        with markers also the sides exchanged, which a checkerboard does not tell.
    """
    columns, rows = board.columns, board.rows
    sizes = [(columns + i, rows + j) for i, j in ((1, 1), (1, 0), (0, 1), (-1, -1))]
    if board.marker is not None:
        sizes.insert(1, (rows, columns))
        sizes.insert(2, (rows + 1, columns + 1))
    return [
        replace(board, columns=x, rows=y)
        for x, y in sizes
        if (x, y) != (columns, rows) and FEWEST_SQUARES <= min(x, y) <= max(x, y) <= MOST_SQUARES
    ]


def _detectors(board: Board, marker: float) -> tuple[cv2.aruco.CharucoDetector, ...]:
    """Return detectors of the board as OpenCV draws it, and as it did before release 4.6."""
    name = f"DICT_{board.marker_bits}X{board.marker_bits}_{board.dictionary_size}"
    dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, name))
    detectors = []
    # both kinds differ only where the number of rows is even
    for is_old in (False, True) if board.rows % 2 == 0 else (False,):
        drawn = cv2.aruco.CharucoBoard(
            (board.columns, board.rows), float(board.square), float(marker), dictionary
        )
        drawn.setLegacyPattern(is_old)
        detectors.append(cv2.aruco.CharucoDetector(drawn))
    return tuple(detectors)


def _sides_on_board(board: Board, uv: FloatArray, markers: FloatArray) -> FloatArray:
    """Return the side of each marker (n, 4, 2) as the corners found around them measure it."""
    seen = np.isfinite(uv[:, 0])
    to_board, _ = cv2.findHomography(uv[seen], board.corners()[seen, :2])
    if to_board is None or not len(markers):
        return np.zeros(0)
    flat = cv2.perspectiveTransform(markers.reshape(-1, 1, 2).astype(float), to_board)
    around = flat.reshape(-1, 4, 2)
    return np.linalg.norm(around - np.roll(around, 1, axis=1), axis=-1).mean(axis=1)


def _pixel_origin(board: Board, detector: cv2.aruco.CharucoDetector) -> FloatArray:
    """Return where the detector counts pixels from: (0, 0), or (0.5, 0.5) in OpenCV before 5.

    Told by the board as it is drawn, whose corners lie on the edges of pixels.
    """
    side = 40
    size = (board.columns * side, board.rows * side)
    corners, ids, _, _ = detector.detectBoard(detector.getBoard().generateImage(size))
    if not (ids is not None and len(ids)):
        return np.zeros(2)
    row, column = np.divmod(np.ravel(ids), board.columns - 1)
    drawn = np.stack([column + 1, row + 1], axis=1) * side - 0.5
    return np.round(2.0 * np.median(np.reshape(corners, (-1, 2)) - drawn, axis=0)) / 2.0


def _checkerboard(grey: ByteArray, shape: tuple[int, int]) -> np.ndarray | None:
    """Find the inner corners of a checkerboard, or None."""
    flags = cv2.CALIB_CB_ACCURACY | cv2.CALIB_CB_NORMALIZE_IMAGE
    found, corners = cv2.findChessboardCornersSB(grey, shape, flags=flags)
    return np.reshape(corners, (-1, 2)).astype(float) if found else None
