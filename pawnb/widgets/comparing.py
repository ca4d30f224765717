"""The part of a review that compares two tracks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np
import pandas as pd

from pawnb.core.rig import Rig
from pawnb.errors import InputError
from pawnb.schema import Tracks
from pawnb.widgets.comparison import Comparison
from pawnb.widgets.retracking import Retracking
from pawnb.widgets.review_session import suspect_options

DIFFERENCE_KEYS = (("C", "the next difference from the other tracks, the largest first"),)


class Comparing(Retracking):
    """A review with a second track beside the first; none where ``_comparison`` is None."""

    _comparison: Comparison | None = None
    _differences: pd.DataFrame | None = None
    _differences_of: Tracks | None = None
    _difference_at = 0

    def _compare_tracks(
        self,
        tracks: Tracks,
        against: Tracks | Literal["before"] | None,
        name: str | None,
        *,
        rig: Rig | None = None,
        listed: Sequence[str] | None = None,
    ) -> None:
        """Take the tracks to compare with."""
        if against is None:
            return
        if isinstance(against, str):
            if against != "before":
                raise InputError(f'against is {against!r}; expected tracks, or "before".')
            against, name = tracks, name or "before the corrections"
        called = "the other tracks" + (f" ({name})" if name else "")
        self._comparison = Comparison(tracks, against, name=called, rig=rig, listed=listed)

    def _show_comparison(self) -> None:
        """Say what the thin line of the lanes is, and how much of it fills one."""
        if self._comparison is None:
            return
        far = self._comparison.farthest(self.corrected.present)
        known = far[np.isfinite(far)]
        self._sd_full = max(10.0, float(np.percentile(known, 99.5)) if len(known) else 0.0)
        self.thin_line = ["distance", f" px from {self._comparison.name}"]
        self._renew_lanes()

    def _lane_spread(self, tracks: Tracks) -> np.ndarray | None:
        """Return the distances that the thin line shows, px."""
        return None if self._comparison is None else self._comparison.farthest(tracks)

    def _draw_others(
        self, frame: int, views: Mapping[str, dict[str, Any]], colours: Mapping[str, str]
    ) -> None:
        """Draw the points of the other tracks over each view."""
        if self._comparison is not None:
            for view, marks in views.items():
                marks["others"] = self._comparison.marks(frame, view, colours)

    def _difference_actions(self) -> list[dict[str, Any]]:
        """Return the menu of differences, and the button that goes to the next."""
        if self._comparison is None:
            return []
        if self._differences_of is not self.corrected.present:
            self._differences_of = self.corrected.present
            self._differences = self._comparison.largest(self._differences_of)
        listed = suspect_options(self._differences)
        return [
            {"id": "difference", "text": "Jump to a difference", "options": listed,
             "title": f"Where the tracks are farthest from {self._comparison.name}"},
            {"id": "apart", "text": "Next difference", "keys": ["c"], "enabled": bool(listed),
             "title": "The difference after the one looked at last, the largest first (C)"},
        ]  # fmt: skip

    def _look_at_difference(self, value: Any) -> int | None:
        """Go to a difference, the next without a value, and choose its point."""
        found = self._differences
        place = int(value) if value else self._difference_at
        if found is None or not 0 <= place < len(found):
            self._difference_at = 0
            self._show_state("That was the last of the differences.")
            return None
        self._difference_at = place + 1
        row = found.iloc[place]
        frame, view, point = int(row["frame"]), str(row["view"]), str(row["point"])
        self._pointed = (frame, view, point)
        self._visit(frame)
        said = f"frame {frame}: {point} in {view}, {row['reason']}"
        self._show_state(f"Difference {place + 1} of {len(found)}, {said}.")
        return frame
