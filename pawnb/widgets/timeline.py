"""The timeline below the pictures: a lane for each point, and what is done to a stretch of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pandas as pd
import traitlets

from pawnb.core.edits.copies import give_back_memory
from pawnb.errors import InputError
from pawnb.schema import Tracks
from pawnb.trial import Trial
from pawnb.widgets.frame_canvas import FrameCanvas
from pawnb.widgets.lanes import Stances, build_lanes, find_stances, sd_scale
from pawnb.widgets.page import as_text

TIMELINE_KEYS = (
    (
        "Drag the frame numbers",
        "go through the recording (wheel, or Ctrl and wheel: zoom in time; double click: all)",
    ),
    ("Click a lane", "go there, and choose its point"),
    ("Drag along a lane", "choose a stretch of that point; its ends can be dragged"),
    ("I, O", "the stretch begins, ends in this frame"),
    ("Esc", "no stretch"),
)
STRETCH_KEYS = (
    ("X", "swap with its fellow, left and right: over the stretch, else to where they meet next"),
    ("N", "interpolate over the stretch"),
    ("H", "the point is not visible over the stretch"),
    ("Delete", "what was tracked over the stretch is wrong"),
)  # fmt: skip


_MOST_DRAWN_FRAMES = 20_000
"""In longer recordings no stances are shown: the analysis, made anew after each correction, takes
about 0.1 s for each thousand frames of four legs, and the player would stutter meanwhile."""


class TimelineCanvas(FrameCanvas):
    """A canvas with a timeline of tracks.

    What stands on it calls :meth:`_prepare_lanes` after it was made, and does in
    :meth:`_do_to_stretch` what is asked for.

    Attributes
    ----------
    lanes : list of dict
        id, colour and partners of each lane's point.
    stretch : list
        The stretch that is chosen: point, first and last frame; empty where none is.
    thin_line : list of str
        What the thin line of the lanes is, in words: before its number, and after it.
    """

    lanes: traitlets.List = traitlets.List().tag(sync=True)
    lanes_do: traitlets.List = traitlets.List().tag(sync=True)
    stretch: traitlets.List = traitlets.List().tag(sync=True)
    thin_line: traitlets.List = traitlets.List(["sd", ""]).tag(sync=True)

    _lane_bytes: np.ndarray | None = None
    _stances: Stances | None = None
    _analysed: Tracks | None = None
    _analysts: ThreadPoolExecutor | None = None

    def _prepare_lanes(
        self,
        trial: Trial,
        tracks: Tracks,
        colours: Mapping[str, str],
        *,
        partners: Mapping[str, Sequence[str]],
        does: Sequence[str],
    ) -> None:
        """Say which points have a lane, whom they may be mistaken for, and what can be done."""
        self._lane_trial, self._sd_full = trial, sd_scale(tracks)
        self._analysts = ThreadPoolExecutor(1, thread_name_prefix="pawnb-stances")
        self.lanes_do = list(does)
        self.lanes = [
            {"id": name, "colour": colour, "partners": list(partners.get(name, ()))}
            for name, colour in colours.items()
        ]
        self._renew_lanes()

    def close(self) -> None:
        """Take the widget away; an analysis that has not begun is not made."""
        if self._analysts is not None:
            self._analysts.shutdown(wait=False, cancel_futures=True)
        super().close()

    def refresh(self, go: int | None = None) -> None:
        """Let the browser ask again for what is drawn, and go to a frame."""
        self._renew_lanes()
        super().refresh(go)

    def _page_traits(self) -> dict[str, Any]:
        """Return what the browser is told on a page that only shows, its lanes too."""
        return super()._page_traits() | {"lanes": self.lanes, "thin_line": self.thin_line}

    def _page_lanes(self, frames: Sequence[int], first: int) -> dict[str, Any]:
        """Return the timeline of a page: that of some frames, counted from ``first`` there."""
        if self._analysts is None or self._lane_bytes is None:
            return {}
        self._analysts.submit(int).result()  # stances that are being looked for
        with self._edit_lock:
            at = np.asarray(frames) - self.span[0]
            data = as_text(self._lane_bytes[:, at].tobytes())
        n = len(frames)
        return {"first": first, "n": n, "begin": 0, "data": data, "sd_full": self._sd_full}

    @traitlets.validate("stretch")
    def _stretch_of_a_lane(self, proposal: Any) -> list[Any]:
        """Refuse a stretch that is none; put its ends in order."""
        given = list(proposal["value"])
        if not given:
            return []
        points = [lane["id"] for lane in self.lanes]
        if len(given) != 3 or given[0] not in points:
            raise InputError(
                f"stretch is {given}; expected a point of {', '.join(points)}, its first and its "
                "last frame."
            )
        low, high = sorted(int(frame) for frame in given[1:])
        first, last = self.span
        if not first <= low <= high <= last:
            raise InputError(
                f"stretch is frames {low} to {high}; the frames are {first} to {last}."
            )
        return [given[0], low, high]

    # --- for what stands on it ------------------------------------------------------------

    def _lane_tracks(self) -> Tracks:
        """Return the tracks as they are now."""
        raise NotImplementedError

    def _lane_spread(self, tracks: Tracks) -> np.ndarray | None:  # noqa: ARG002
        """Return what the thin line shows in place of the standard deviation, (n, P)."""
        return None

    def _tell_of_tracks(self) -> None:
        """Take notice of other tracks than those of before."""

    def _lane_suspects(self) -> pd.DataFrame | None:
        """Return the labels that are doubtful now."""
        raise NotImplementedError

    def _do_to_stretch(
        self, action: str, point: str, stretch: tuple[int, int], message: Mapping[str, Any]
    ) -> int | None:
        """Do what was asked for to a stretch: its first frame, and one past its last."""
        raise NotImplementedError

    # --- inside -----------------------------------------------------------------------------

    def _edit_stretch(self, message: Mapping[str, Any]) -> int | None:
        """Do what a person asked for on the timeline."""
        given = message.get("stretch")
        point = str(message["point"])
        if given:
            low, high = sorted(int(frame) for frame in given)
            first, last = self.span
            stretch = max(low, first), min(high, last) + 1
        else:
            stretch = int(message["frame"]), self.span[1] + 1
        return self._do_to_stretch(str(message["action"]), point, stretch, message)

    def _receive(self, widget: Any, message: dict[str, Any], buffers: Any) -> None:
        """Answer one message of the browser."""
        if message.get("type") == "lanes":
            with self._edit_lock:
                if self._lane_bytes is not None:
                    self._send_lanes(0, self._lane_bytes.shape[1])
            return
        super()._receive(widget, message, buffers)

    def _answer_edit(self, message: dict[str, Any]) -> None:
        """Do what was asked, say that it is done, and show it in the lanes."""
        super()._answer_edit(message)
        self._renew_lanes()

    def _renew_lanes(self) -> None:
        """Send what has changed in the lanes, and look for stances anew."""
        if self._analysts is None:
            return
        with self._edit_lock:
            tracks = self._lane_tracks()
            new = build_lanes(
                tracks,
                [lane["id"] for lane in self.lanes],
                suspects=self._lane_suspects(),
                stances=self._stances,
                sd_full=self._sd_full,
                spread=self._lane_spread(tracks),
            )
            old, self._lane_bytes = self._lane_bytes, new
            if old is not None and old.shape == new.shape:
                changed = np.flatnonzero((old != new).any(axis=(0, 2)))
                if len(changed):
                    self._send_lanes(int(changed[0]), int(changed[-1]) + 1)
            else:
                self._send_lanes(0, new.shape[1])
            if tracks is not self._analysed:
                first, self._analysed = self._analysed is None, tracks
                self._look_for_stances(tracks)
                if not first:
                    self._tell_of_tracks()
        if tracks.sizes["time"] > _MOST_DRAWN_FRAMES:
            give_back_memory()

    def _send_lanes(self, begin: int, stop: int) -> None:
        """Send some frames of all lanes; as text, since some front ends lose binary messages."""
        assert self._lane_bytes is not None  # noqa: S101
        part = np.ascontiguousarray(self._lane_bytes[:, begin:stop])
        data = as_text(part.tobytes())
        n, first = self._lane_bytes.shape[1], self.span[0]
        self.send({"type": "lanes", "first": first, "n": n, "begin": begin, "data": data,
                   "sd_full": self._sd_full})  # fmt: skip

    def _look_for_stances(self, tracks: Tracks) -> None:
        """Analyse the gait off this thread; only the newest tracks count."""

        def look() -> None:
            if tracks is not self._analysed:
                return  # corrected again meanwhile
            found = find_stances(tracks, self._lane_trial)
            if tracks is self._analysed and found != self._stances:
                self._stances = found
                self._renew_lanes()

        assert self._analysts is not None  # noqa: S101
        if tracks.sizes["time"] > _MOST_DRAWN_FRAMES:
            return
        try:
            self._analysts.submit(look)
        except RuntimeError:
            return  # the widget was closed meanwhile
