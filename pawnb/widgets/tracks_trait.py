"""``tracks`` of the reviewers, as users of ipywidgets expect it: observed, set and checked."""

from __future__ import annotations

from typing import Any

import traitlets

from pawnb.schema import Tracks, check_tracks


class TracksTrait(traitlets.TraitType):
    """The tracks that a reviewer holds.

    The reviewer has ``corrected``, takes other tracks in ``_take_tracks``, and calls
    :meth:`changed` when there are others.
    """

    def get(self, obj: Any, cls: type | None = None) -> Tracks:  # noqa: ARG002
        """Return the tracks as corrected so far."""
        tracks: Tracks = obj.corrected.tracks
        return tracks

    def set(self, obj: Any, value: Any) -> None:
        """Check other tracks, and let the reviewer show them."""
        check_tracks(value)
        obj._take_tracks(value)

    def changed(self, obj: Any) -> None:
        """Tell who observes them."""
        # made only where somebody wants them; datasets are not compared with one another
        if obj._trait_notifiers.get(self.name) or obj._trait_notifiers.get(traitlets.All):
            obj.notify_change(
                traitlets.Bunch(
                    name=self.name, old=None, new=self.get(obj), owner=obj, type="change"
                )
            )
