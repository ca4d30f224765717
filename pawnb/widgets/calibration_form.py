"""How a trial is to be calibrated, asked for on the workbench's page; opens the digitiser."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import ipywidgets as widgets

from pawnb.core.calibration.rig_from_boards import tell_disagreement
from pawnb.core.video import open_view
from pawnb.errors import InputError, PawnbError
from pawnb.io.boards import Board, read_board
from pawnb.trial import Trial, View
from pawnb.widgets.calibration_digitiser import CalibrationDigitiser
from pawnb.widgets.calibration_pictures import BoardPictures
from pawnb.widgets.calibration_wand import WandClicks
from pawnb.widgets.form_draft import FormDraft
from pawnb.widgets.plain import Plain
from pawnb.workflow.calibration.name_in_trial import name_calibration

_CALIBRATION_ROW = {"flex_flow": "row wrap", "align_items": "center"}
_CALIBRATION_WIDTH = {"width": "26em"}
_CALIBRATION_WAYS = (
    ("two clicks a known distance apart (one view)", "scale"),
    ("known points: a table point, x, y, z", "points"),
    ("pictures of a checkerboard or ChArUco board", "board"),
    ("a wand of known length", "wand"),
)


class CalibrationForm(Plain, widgets.VBox):  # type: ignore[misc]
    """Calibrate the views of a trial: say how, click, and the trial names what was written.

    Parameters
    ----------
    trial : Trial
        The trial.
    done : callable, optional
        ``done(said)`` is called once ``trial.toml`` names the calibration, with what to know of it.
    **options
        The options of :class:`FrameCanvas`.

    Attributes
    ----------
    digitiser : CalibrationDigitiser or None
        What is clicked in, once it was opened.
    """

    def __init__(
        self, trial: Trial, *, done: Callable[[str], object] | None = None, **options: Any
    ) -> None:
        super().__init__()
        self.trial, self._done, self._options = trial, done, options
        self.digitiser: CalibrationDigitiser | None = None
        ways = (
            _CALIBRATION_WAYS
            if len(trial.views) == 1
            else (*_CALIBRATION_WAYS[1:], _CALIBRATION_WAYS[0])
        )
        self.way = widgets.Dropdown(options=ways, description="by", layout={"width": "31em"})
        tables = sorted(p.name for p in trial.folder.glob("*") if p.suffix in (".csv", ".toml"))
        self.file = widgets.Combobox(
            options=tables, placeholder="a file in the trial's folder", description="file",
            layout=_CALIBRATION_WIDTH,
        )  # fmt: skip
        self.length = widgets.Text(placeholder="its length", description="wand")
        self.squares = widgets.Text(placeholder="8 x 6, or by a file", description="squares")
        self.side = widgets.Text(placeholder="side of one", description="each")
        given = trial.calibration
        self.unit = widgets.Text(
            value="mm" if given is None else given.unit, description="unit",
            layout={"width": "10em"},
        )  # fmt: skip
        self.films = {
            view.name: widgets.Text(
                value=view.video, description=view.name, layout=_CALIBRATION_WIDTH
            )
            for view in trial.views
        }
        begin = widgets.Button(description="Show the pictures", button_style="primary")
        begin.on_click(lambda _: self._guard(self.begin))
        use = widgets.Button(description="Use this calibration", layout={"width": "auto"})
        use.on_click(lambda _: self._guard(self.use))
        self._told = widgets.Label()
        self._told.add_class("pawnb-wrap")
        self._place = widgets.VBox()
        self.way.observe(lambda _: self._show_fields(), names="value")
        named = {"way": self.way, "file": self.file, "length": self.length, "side": self.side,
                 "squares": self.squares, "unit": self.unit}  # fmt: skip
        films = {f"film {name}": field for name, field in self.films.items()}
        # what was typed is there again when the kernel has ended; clicks have files of their own
        self._draft = FormDraft(trial.folder / ".calibration-draft.json", named | films)
        self._show_fields()
        self.children = (
            widgets.HBox(
                [self.way, self.file, self.length, self.squares, self.side, self.unit],
                layout=_CALIBRATION_ROW,
            ),
            widgets.HBox([*self.films.values()], layout=_CALIBRATION_ROW),
            widgets.HBox([begin, use, self._told], layout=_CALIBRATION_ROW), self._place,
        )  # fmt: skip

    def begin(self) -> None:
        """Open the pictures to be clicked in, as the fields say."""
        pictures = {name: self.trial.path(field.value) for name, field in self.films.items()}
        made = CalibrationDigitiser(
            pictures, folder=self.trial.folder, trial=self.trial, **self._by(), **self._options
        )
        if self.digitiser is not None:
            self.digitiser.close()
        self.digitiser = made
        self._place.children = (made,)
        self._told.value = ""

    def use(self) -> None:
        """Let the trial name the calibration; what is not written yet is written first."""
        made = self.digitiser
        if made is None:
            raise InputError("show the pictures and calibrate first.")
        if made.doing:
            raise InputError(f"{made.doing}; wait for its end, then press again.")
        session = made.session
        if session is None:
            if made.trial is None or made.trial.calibration is None:
                raise InputError("click both ends of a known length, and press Use this scale.")
            self.trial = made.trial
        else:
            if not session.can_save:
                raise InputError(f"not every view is determined yet. {session.prompt()}")
            self._check_sizes(session.sizes)
            if session.written is None:
                made.edit("action", {"action": "save", "frame": made.frame})
            if session.written is not None:
                unit = self.unit.value.strip() or "mm"
                self.trial = name_calibration(self.trial, session.written, unit=unit)
        self._draft.forget()
        if self._done is not None:
            self._done(_said_of_axes(self.trial, session))

    def plain_picture(self) -> bytes:
        """Return the pictures that are clicked in, as PNG."""
        if self.digitiser is None:
            raise InputError("no picture is shown yet.")
        return self.digitiser.plain_picture()

    def close(self) -> None:
        """Take the form away and close the pictures."""
        if self.digitiser is not None:
            self.digitiser.close()
        super().close()

    # --- inside ---------------------------------------------------------------------------

    def _check_sizes(self, clicked: Mapping[str, tuple[int, int]]) -> None:
        """Raise InputError where the pictures that were clicked in are of another size."""
        for view in self.trial.views:
            whole = View(name=view.name, video=view.video)
            with open_view(whole, self.trial.folder) as reader:
                size = (reader.width, reader.height)
            if clicked[view.name] != size:
                said = [f"{w} x {h} px" for w, h in (clicked[view.name], size)]
                raise InputError(
                    f"{view.name} was calibrated in pictures of {said[0]}, and its film has "
                    f"{said[1]}: one place has other pixels in both. Film the calibration as the "
                    "trial is filmed, or bring both to one size."
                )

    def _by(self) -> dict[str, Any]:
        """Return what the views are calibrated by."""
        way = self.way.value
        if way == "wand":
            return {"wand": _number(self.length.value, "the length of the wand")}
        if way == "board" and self.squares.value.strip():
            return {"board": self._board()}
        if way in ("points", "board"):
            if not self.file.value.strip():
                words = (
                    "known points" if way == "points" else "board, or say how many squares it has"
                )
                raise InputError(f"name the file of the {words}.")
            path = self.trial.path(self.file.value.strip())
            return {way: read_board(path) if way == "board" else path}
        return {}

    def _board(self) -> Board:
        """Return the checkerboard that the fields describe."""
        words = self.squares.value.lower().replace("x", " ").replace("×", " ").split()
        if len(words) != 2 or not all(word.isdigit() for word in words):
            raise InputError(f"squares is {self.squares.value!r}; expected such as 8 x 6.")
        side = _number(self.side.value, "the side of a square")
        return Board(columns=int(words[0]), rows=int(words[1]), square=side)

    def _show_fields(self) -> None:
        """Show what is asked for of the chosen way."""
        way = self.way.value
        for field, ways in (
            (self.file, ("points", "board")), (self.length, ("wand",)),
            (self.squares, ("board",)), (self.side, ("board",)),
            (self.unit, ("points", "board", "wand")),
        ):  # fmt: skip
            field.layout.display = None if way in ways else "none"

    def _guard(self, act: Callable[[], object]) -> None:
        """Do something; say what is wrong where it cannot be done."""
        try:
            act()
        except (PawnbError, OSError) as error:
            self._told.value = str(error)


def _said_of_axes(trial: Trial, session: Any) -> str:
    """Say what is taken for forward and up: a board and a wand give axes of their own."""
    said = "calibrated"
    fitted = session.fitted if isinstance(session, BoardPictures) else None
    if fitted is not None and (doubt := tell_disagreement(fitted)) is not None:
        said += f", but look: {doubt}"
    if isinstance(session, BoardPictures | WandClicks) and trial.calibration is not None:
        ways = [
            f"({', '.join(f'{number:g}' for number in way)})"
            for way in (trial.calibration.forward, trial.calibration.up)
        ]
        said += (
            f". In its axes {ways[0]} is taken for forward and {ways[1]} for up: where the animal "
            "runs another way, write forward and up into trial.toml, [calibration]"
        )
    return f"{said}."


def _number(text: str, what: str) -> float:
    """Return the number of a field."""
    try:
        return float(text.strip().replace(",", "."))
    except ValueError:
        raise InputError(f"{what} is {text!r}; expected a number.") from None
