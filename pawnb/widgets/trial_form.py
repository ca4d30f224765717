"""A form that makes a trial of bare videos: what ``pawnb new`` asks for, on one page."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import ipywidgets as widgets

from pawnb.errors import InputError, PawnbError
from pawnb.widgets.crop_canvas import CropCanvas
from pawnb.widgets.flash_field import FlashField
from pawnb.widgets.form_draft import FormDraft
from pawnb.widgets.plain import Plain
from pawnb.workflow.workbench.animals import ANIMALS, OTHER_ANIMAL, choose_animal
from pawnb.workflow.workbench.film_alignment import tell_alignment
from pawnb.workflow.workbench.new_trial import (
    NewTrial,
    NewView,
    new_trial,
    part_of_frames,
    second_view,
)

_TRIAL_ROW = {"flex_flow": "row wrap"}
_TRIAL_WIDTH = {"width": "22em"}
_NUMBER = {"width": "12em"}
_NONE = "none"


class TrialForm(Plain, widgets.VBox):  # type: ignore[misc]
    """Make a trial of some videos: it is written when *Make the trial* is pressed.

    Until then what was typed and dragged is kept in ``.trial-draft.json`` beside it, which goes
    away with that: nothing is lost where the kernel ends.

    Parameters
    ----------
    videos : sequence of str or Path
        The video of each view.
    folder : str or Path, optional
        Where ``trial.toml`` is to be; default that of the first video.
    done : callable, optional
        ``done(path)`` is called with the file that was written.

    Attributes
    ----------
    made : NewTrial
        What is known so far; works without a browser.

    Raises
    ------
    InputError
        If a video cannot be opened, or the folder has a trial already.
    """

    def __init__(
        self,
        videos: Sequence[str | Path],
        folder: str | Path | None = None,
        *,
        done: Callable[[Path], object] | None = None,
    ) -> None:
        super().__init__()
        self.made: NewTrial = new_trial(videos, folder)
        self._done = done
        self._told, self._aligned = widgets.Label(), widgets.Label()
        for label in (self._told, self._aligned):
            label.add_class("pawnb-wrap")
        self._canvas: CropCanvas | None = None
        self._draft: FormDraft | None = None
        self._rows: list[_ViewRow] = []
        self._make_fields()
        self._pictures, self._of_views = widgets.VBox(), widgets.VBox()
        self._make = widgets.Button(
            description="Make the trial", button_style="primary", icon="check"
        )
        self._make.on_click(lambda _: self.write())
        # shown once: a field that is made anew in the page loses what is being typed there
        fields = [self.name, self.animal_id, self.animal, self.points, self.fps, self.unit,
                  self.dlt, self.px_per_unit, self.belt]  # fmt: skip
        self.children = (
            widgets.HBox(fields, layout=_TRIAL_ROW), self._pictures, self._aligned,
            self._of_frames(), self._of_views,
            widgets.HBox([self._make, self._told], layout=_TRIAL_ROW),
        )  # fmt: skip
        self._draft = FormDraft(
            self.made.folder / ".trial-draft.json", self._fields(), more=self._views_typed
        )
        self.made.views = _views_of(self._draft.kept_more, self.made.views)
        self._show_views()

    def write(self) -> Path | None:
        """Write the trial as the form says; returns the file, or says what is wrong."""
        try:
            self._take()
            path = self.made.write()
        except (PawnbError, OSError) as error:
            self._tell(str(error), wrong=True)
            return None
        if self._draft is not None:
            self._draft.forget()
        self._tell(f"Wrote {path}.")
        if self._done is not None:
            self._done(path)
        return path

    def plain_picture(self) -> bytes:
        """Return the videos with the part of each that is kept, as PNG."""
        if self._canvas is None:
            raise InputError("the form shows no video.")
        return self._canvas.plain_picture()

    def close(self) -> None:
        """Take the form away and close the videos."""
        if self._canvas is not None:
            self._canvas.close()
        super().close()

    # --- inside ---------------------------------------------------------------------------

    def _make_fields(self) -> None:
        """Make what is asked for of the whole trial."""
        made = self.made
        self.name = widgets.Text(value=made.folder.resolve().name, description="trial")
        self.animal_id = widgets.Text(placeholder="as the trial", description="animal's id")
        options = [(f"{a.name}: {a.words}", a.name) for a in ANIMALS]
        self.animal = widgets.Dropdown(options=options, description="animal", layout=_TRIAL_WIDTH)
        self.points = widgets.Text(
            placeholder="names with commas between", description="points", layout=_TRIAL_WIDTH
        )
        _set_shown(self.points, False)
        self.fps = widgets.Text(placeholder="frames a second", description="filmed at")
        self.unit = widgets.Text(value=made.unit, description="unit", layout={"width": "10em"})
        csvs = sorted(made.folder.glob("*.csv"))
        files = [(_NONE, ""), *((file.name, str(file)) for file in csvs)]
        self.dlt = widgets.Dropdown(
            options=files, value=str(made.dlt or ""), description="DLT", layout=_TRIAL_WIDTH
        )
        self.px_per_unit = widgets.Text(placeholder="px in one unit", description="scale")
        self.belt = widgets.Text(placeholder="unit a second, or none", description="treadmill")
        self.animal.observe(self._on_animal, names="value")
        self.first = widgets.Text(placeholder="first", description="from frame", layout=_NUMBER)
        self.last = widgets.Text(placeholder="last", description="to frame", layout=_NUMBER)

    def _of_frames(self) -> widgets.HBox:
        """Return what asks for the frames to use: typed, or those that the pictures show."""
        row = []
        for field, words in ((self.first, "Begin here"), (self.last, "End here")):
            here = widgets.Button(
                description=words,
                tooltip="Use frames in which the animal is in the picture: the one shown is taken",
                layout={"width": "8em"},
            )
            here.on_click(lambda _, field=field: self._take_frame(field))
            row += [field, here]
        return widgets.HBox(row, layout=_TRIAL_ROW)

    def _take_frame(self, field: widgets.Text) -> None:
        """Fill in the frame that the pictures show."""
        if self._canvas is not None:
            field.value = str(self._canvas.frame)

    def _fields(self) -> dict[str, Any]:
        """Return the fields of the whole trial by name."""
        names = ("name", "animal_id", "animal", "points", "fps", "unit", "dlt", "px_per_unit",
                 "belt", "first", "last")  # fmt: skip
        return {name: getattr(self, name) for name in names}

    def _views_typed(self) -> list[dict[str, Any]]:
        """Return the views as the rows have them."""
        self._keep()
        return [
            {"video": str(view.video), "name": view.name, "mirror": view.mirror,
             "points": list(view.points), "event": view.event,
             "crop": None if view.crop is None else list(view.crop)}
            for view in self.made.views
        ]  # fmt: skip

    def _on_change(self) -> None:
        """Keep what was typed or dragged."""
        if self._draft is not None:
            self._draft.keep()

    def _on_animal(self, _change: Any) -> None:
        """Ask for the points where the list does not know them."""
        _set_shown(self.points, self.animal.value == OTHER_ANIMAL)

    def _show_views(self) -> None:
        """Show the pictures, one row a view, and the calibration that so many views need."""
        made = self.made
        several = len(made.views) > 1
        self._show_pictures(None if self._canvas is None else self._canvas.frame)
        self._rows = [_ViewRow(self, view, several=several) for view in made.views]
        self._of_views.children = [row.box for row in self._rows]
        _set_shown(self.dlt, several)
        _set_shown(self.px_per_unit, not several)
        self._on_change()  # a view may have come or gone

    def _show_pictures(self, frame: int | None) -> None:
        """Show the pictures, aligned as far as that is known, at a frame."""
        made = self.made
        canvas = CropCanvas(made, changed=self._on_change, frame=frame, max_height=420)
        if self._canvas is not None:
            self._canvas.close()
        self._canvas, self._shown_offsets = canvas, made.offsets_so_far
        self._film_lengths = canvas.film_lengths()
        self._pictures.children = [canvas]
        names = {film: view.name for film, view in made.films.items()}
        self._aligned.value = tell_alignment(
            {names[film]: offset for film, offset in self._shown_offsets.items()},
            {names[film]: n for film, n in self._film_lengths.items()},
        )

    def _frame_of_film(self, view: NewView) -> int:
        """Return which frame of its file a view shows."""
        shown = 0 if self._canvas is None else self._canvas.frame
        return shown + self._shown_offsets[view.video]

    def _align(self) -> None:
        """Show the pictures aligned once the flash is marked in every film."""
        try:
            for row in self._rows:
                row.take()
            offsets = self.made.offsets
            if offsets != self._shown_offsets:
                events = [v.event for v in self.made.films.values() if v.event is not None]
                self._show_pictures(min(events, default=None))
                # frames that were named before are counted otherwise now
                self.first.value = self.last.value = ""
        except InputError as error:
            self._tell(str(error), wrong=True)
        else:
            self._tell("")
        self._on_change()

    def _take(self) -> None:
        """Take over what the fields say; raises InputError for what makes no sense."""
        made = self.made
        made.name, made.animal_id = self.name.value.strip(), self.animal_id.value.strip()
        made.animal = choose_animal(self.animal.value)
        made.points = _names(self.points.value)
        made.fps = _number(self.fps.value, "filmed at")
        made.unit = self.unit.value.strip() or "mm"
        several = len(made.views) > 1
        made.dlt = Path(self.dlt.value) if several and self.dlt.value else None
        made.px_per_unit = None if several else _number(self.px_per_unit.value, "scale")
        made.belt_speed = _number(self.belt.value, "treadmill")
        if self._canvas is not None:
            first, last = _frame(self.first.value), _frame(self.last.value)
            made.frames = part_of_frames(first, last, self._canvas.span[1] + 1)
        for row in self._rows:
            row.take()

    def _keep(self) -> None:
        """Take over what the rows say, as far as it makes sense, before they are made anew."""
        for row in self._rows:
            with suppress(InputError):
                row.take()

    def _add(self, view: NewView) -> None:
        """Add another view of the same video."""
        self._keep()
        views = self.made.views
        other = second_view(view, [v.name for v in views])
        self._show([v for own in views for v in ((own, other) if own is view else (own,))])

    def _remove(self, view: NewView) -> None:
        """Leave a view out."""
        self._keep()
        self._show([own for own in self.made.views if own is not view])

    def _show(self, views: list[NewView]) -> None:
        """Show other views; where that cannot be, say why and keep those there are."""
        before, self.made.views = self.made.views, views
        try:
            self._show_views()
        except InputError as error:
            self.made.views = before
            self._tell(str(error), wrong=True)

    def _tell(self, text: str, *, wrong: bool = False) -> None:
        """Say something beside the button."""
        self._told.value = text
        self._told.style.text_color = "#D32F2F" if wrong else None


class _ViewRow:
    """What is asked for of one view."""

    def __init__(self, form: TrialForm, view: NewView, *, several: bool) -> None:
        self._form, self._view = form, view
        self.name = widgets.Text(value=view.name, description="view", layout={"width": "16em"})
        self.mirror = widgets.Checkbox(
            value=view.mirror, description="seen in a mirror", indent=False,
            layout={"width": "11em"},
        )  # fmt: skip
        self.points = widgets.Text(
            value=", ".join(view.points), placeholder="all points", description="sees",
            layout=_TRIAL_WIDTH,
        )  # fmt: skip
        for field in (self.name, self.mirror, self.points):
            field.observe(lambda _: form._on_change(), names="value")
        again = widgets.Button(
            description="Another view in this video",
            tooltip="As where a mirror shows the animal from below",
            layout={"width": "16em"},
        )
        again.on_click(lambda _: form._add(view))
        row = [self.name, self.mirror, *([self.points] if several else []), again]
        if several:
            gone = widgets.Button(description="Leave out", layout={"width": "8em"})
            gone.on_click(lambda _: form._remove(view))
            row.append(gone)
        self._flash: FlashField | None = None
        films = form.made.films
        if len(films) > 1 and films[view.video] is view:
            self._flash = FlashField(
                view.event, film=view.name, n_frames=form._film_lengths[view.video],
                here=lambda: form._frame_of_film(view), changed=form._align,
            )  # fmt: skip
            row.insert(2, self._flash)
        self.box = widgets.HBox(row, layout=_TRIAL_ROW)

    def take(self) -> None:
        """Take over what the fields say."""
        self._view.name = self.name.value.strip()
        self._view.mirror = bool(self.mirror.value)
        self._view.points = _names(self.points.value)
        if self._flash is not None:
            event = self._flash.frame()
            for view in self._form.made.views:  # a mirror's film is the same
                if view.video == self._view.video:
                    view.event = event


def _set_shown(field: widgets.Widget, shown: bool) -> None:
    """Show a field, or hide it where it is."""
    field.layout.display = None if shown else "none"


def _views_of(kept: Any, given: list[NewView]) -> list[NewView]:
    """Return the views of a draft; those given where it is of other videos, or none."""
    try:
        views = [
            NewView(Path(one["video"]), str(one["name"]), mirror=bool(one["mirror"]),
                    points=tuple(map(str, one["points"])),
                    crop=None if one["crop"] is None else _box(one["crop"]),
                    event=None if one.get("event") is None else int(one["event"]))
            for one in kept
        ]  # fmt: skip
    except (TypeError, KeyError, ValueError):
        return given
    return views if {v.video for v in views} == {v.video for v in given} else given


def _box(values: Sequence[Any]) -> tuple[int, int, int, int]:
    """Return the part of a picture that four numbers say."""
    u0, v0, u1, v1 = map(int, values)
    if not (0 <= u0 < u1 and 0 <= v0 < v1):
        raise ValueError(values)
    return u0, v0, u1, v1


def _names(text: str) -> tuple[str, ...]:
    return tuple(name for word in text.split(",") if (name := word.strip()))


def _frame(text: str) -> int | None:
    """Return the frame that a field names, None where it is empty."""
    if not (word := text.strip()):
        return None
    if not word.isdecimal():
        raise InputError(f"a frame to use is {text!r}; expected a number, the first frame being 0.")
    return int(word)


def _number(text: str, what: str) -> float | None:
    """Return the number of a field, None where it is empty."""
    word = text.strip().replace(",", ".")
    if word in ("", _NONE):
        return None
    try:
        return float(word)
    except ValueError:
        raise InputError(f"{what} is {text!r}; expected a number.") from None
