"""What every way of calibrating shares: clicks in still views, some set aside, saved as made."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Protocol, TypeVar

from pawnb.errors import InputError
from pawnb.io.tables import write_table
from pawnb.widgets.draft import Draft
from pawnb.workflow.calibration.written import Written


class _HasAside(Protocol):
    """A state in which something is set aside."""

    @property
    def aside(self) -> frozenset[Any]: ...


@dataclass(frozen=True)
class ClickState:
    """What undo goes back to: clicks by their slots, u, v in px, and what is set aside."""

    clicks: Mapping[Any, tuple[float, float]] = field(default_factory=dict)
    aside: frozenset[Any] = frozenset()


AsideT = TypeVar("AsideT", bound=_HasAside)
ClicksT = TypeVar("ClicksT", bound=ClickState)


class CalibrationDraft(Draft[AsideT]):
    """What a person does to calibrate views, of which some can be set aside.

    Parameters
    ----------
    path : Path
        The file of what is done; the calibration goes into its folder.
    sizes : mapping of str to tuple of int
        Width and height of each view, px.
    span : tuple of int
        First and last frame.

    Attributes
    ----------
    frame : int
        The frame looked at.
    current : tuple of str or None
        View and name of what is asked for, or chosen.
    written : Written or None
        What was saved last.
    """

    def __init__(
        self, path: Path, *, sizes: Mapping[str, tuple[int, int]], span: tuple[int, int]
    ) -> None:
        super().__init__(path, span)
        self.sizes, self.folder, self.frame = dict(sizes), path.parent, span[0]
        self.current: tuple[str, str] | None = None
        self.written: Written | None = None

    @property
    def aside(self) -> frozenset[Any]:
        """What a person has set aside: clicks, or pairs of view and frame."""
        return self._state.aside

    def go(self, frame: int) -> None:
        """Look at another frame."""
        self.frame = self._checked_frame(frame)


class ClickDraft(CalibrationDraft[ClicksT]):
    """Clicks on named things in every view: they are placed, moved, taken away and taken back."""

    names: Sequence[str]
    """What is clicked in each view, in order."""

    @property
    def clicks(self) -> dict[Any, tuple[float, float]]:
        """Every click: its slot to u, v in px."""
        return dict(self._state.clicks)

    def click(self, view: str, u: float, v: float) -> None:
        """Place what is asked for in a view.

        Parameters
        ----------
        view : str
            The view.
        u, v : float
            Where, px.

        Raises
        ------
        InputError
            If everything is clicked there.
        """
        name = self.asked_in(view)
        if name is None:
            raise InputError(self._all_clicked(view))
        self.place(view, name, u, v)

    def asked_in(self, view: str) -> str | None:
        """Return what a click in a view places; None where everything is clicked."""
        free = [name for name in self.names if self._slot(view, name) not in self._state.clicks]
        if self.current is not None and self._is_asked(self.current, view, free):
            return self.current[1]
        return free[0] if free else None

    def place(self, view: str, point: str, u: float, v: float) -> None:
        """Put something somewhere in a view: a click, or the end of a drag.

        Parameters
        ----------
        view, point : str
            What, in which view.
        u, v : float
            Where, px.

        Raises
        ------
        InputError
            If that is outside the picture.
        """
        slot = self._slot(view, point)
        width, height = self.sizes[view]
        if not (-0.5 <= u < width - 0.5 and -0.5 <= v < height - 0.5):
            raise InputError(f"{point} at ({u:.1f}, {v:.1f}) is outside the picture of {view}.")
        self._make(self._with_click(slot, (round(float(u), 3), round(float(v), 3))))
        self.current = (view, point)
        self._offer_next()

    def select(self, view: str, point: str) -> None:
        """Ask for something, or choose it."""
        self._slot(view, point)
        self.current = (view, point)

    def remove(self, view: str, point: str) -> None:
        """Take a click away."""
        self._make(self._without_click(self._slot(view, point)))
        self.current = (view, point)

    def _with_click(self, slot: Any, uv: tuple[float, float]) -> ClicksT:
        return replace(self._state, clicks={**self._state.clicks, slot: uv})

    def _without_click(self, slot: Any) -> ClicksT:
        clicks = {key: uv for key, uv in self._state.clicks.items() if key != slot}
        return replace(self._state, clicks=clicks)

    def _changed_slots(self, before: ClicksT) -> set[Any]:
        """Return the slots whose click undo or redo has changed."""
        was, now = before.clicks, self._state.clicks
        return {slot for slot in {*was, *now} if was.get(slot) != now.get(slot)}

    def _offer_next(self) -> None:
        """Ask for what is open next: in the view that was clicked, else in another."""
        views = list(self.sizes)
        if self.current is not None:
            at = views.index(self.current[0])
            views = views[at:] + views[:at]
        free = [(v, n) for v in views for n in self.names
                if self._slot(v, n) not in self._state.clicks]  # fmt: skip
        self.current = free[0] if free else self.current

    def _is_asked(self, current: tuple[str, str], view: str, free: Sequence[str]) -> bool:
        """Say whether a click in a view places what is asked for; each kind says how."""
        raise NotImplementedError

    def _all_clicked(self, view: str) -> str:
        """Say that nothing is left to click in a view; each kind says how."""
        raise NotImplementedError

    def _slot(self, view: str, name: str) -> Any:
        """Return where a click on something in a view is kept, refusing unknown ones."""
        raise NotImplementedError

    def table(self) -> Any:
        """Return the clicks as they are saved; each kind says how."""
        raise NotImplementedError

    def _write(self) -> None:
        write_table(self.table(), self.path)
