"""The kinds of trials, and what follows from the kind alone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Kind = Literal["paws", "pose", "tracks"]


@dataclass(frozen=True)
class KindTraits:
    """What is true of every trial of a kind: whoever needs to know asks for this, not for the kind.

    Parameters
    ----------
    is_jointed : bool
        Whether a jointed animal is posed, of which the species tells; else points are placed.
    takes_detections : bool
        Whether other programs' detections, and a network that follows points, are taken as
        evidence.
    has_recording : bool
        Whether there are videos to track; else another program has tracked it.
    """

    is_jointed: bool = False
    takes_detections: bool = False
    has_recording: bool = True


TRAITS: dict[Kind, KindTraits] = {
    "paws": KindTraits(takes_detections=True),
    "pose": KindTraits(is_jointed=True),
    "tracks": KindTraits(has_recording=False),
}
