"""Which points are followed, and what detections say of each.

Where a view shows paws of the other side that nobody clicked, they are followed too, as unlabelled
targets, lest they be taken for the points of their kind.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pawnb.arrays import BoolArray, FloatArray
from pawnb.core.paws.offline.association.network_flow.contralateral import (
    share_observed,
    with_contralateral,
)
from pawnb.core.paws.offline.association.network_flow.tracklet_association import (
    TrackletAssociator,
)
from pawnb.core.paws.offline.detection.colour.label_offsets import learn_offsets
from pawnb.core.paws.offline.detection.colour.likelihood import AppearanceLikelihood
from pawnb.core.paws.offline.detection.colour.observations import Observations, read_observations
from pawnb.core.paws.offline.scene.clicks import unlabelled_kinds
from pawnb.core.paws.offline.treadmill.recording import Recording


@dataclass(frozen=True)
class Targets:
    """The points; unlabelled targets come after those that were clicked.

    Parameters
    ----------
    kinds : list of str
        Kind of each.
    certain : ndarray, shape (n, P + S, V, 2)
        Image positions placed by hand, px, NaN elsewhere.
    tracked_in_view : ndarray of bool, shape (P + S, V)
        Which view tracks which.
    observations : Observations
        What every view shows.
    likelihood : AppearanceLikelihood
        How much a detection looks like a paw.
    unsure : ndarray, shape (P + S,)
        Standard error of where the points lie on paws, in paw widths.
    is_one_sided : bool
        Whether paws of the other side were not clicked.
    """

    kinds: list[str]
    certain: np.ndarray
    tracked_in_view: BoolArray
    observations: Observations
    likelihood: AppearanceLikelihood
    unsure: FloatArray
    is_one_sided: bool


def choose_targets(recording: Recording) -> tuple[Targets, TrackletAssociator, FloatArray]:
    """Return the points to follow, their tracklets, and where they are by the clicks alone.

    An unlabelled target without a paw of its own would share that of its kind: it is left out.

    Parameters
    ----------
    recording : Recording
        What is given.

    Returns
    -------
    targets : Targets
        The points.
    paths : TrackletAssociator
        The tracklets, to be chosen from.
    first : ndarray, shape (n, P + S, d)
        The first choice, NaN where occluded.
    """
    extra = unlabelled_kinds(recording.layout.kinds)
    while True:
        targets = learn_targets(recording, extra)
        paths = build_paths(recording, targets)
        first = paths.first()
        share = share_observed(
            first, recording.anchors, recording.scene, body=paths.body(first), kinds=targets.kinds
        )
        own = share >= recording.scene.geometry.least_observed
        if own.all():
            return targets, paths, first
        extra = [kind for kind, kept in zip(extra, own, strict=True) if kept]


def learn_targets(recording: Recording, extra: Sequence[str]) -> Targets:
    """Learn from the clicks what detections say of points and of targets of the kinds ``extra``.

    Parameters
    ----------
    recording : Recording
        What is given.
    extra : sequence of str
        Kinds of unlabelled targets, "front" or "hind".

    Returns
    -------
    Targets
        Both.
    """
    scene, layout, reference = recording.scene, recording.layout, recording.reference
    paw_width_px, facing = scene.paw_width_px, layout.facing
    kinds = [*layout.kinds, *extra]
    room = ((0, 0), (0, len(extra)), (0, 0), (0, 0))
    certain = np.pad(recording.certain, room, constant_values=np.nan)
    clicks = np.pad(reference.clicks, room, constant_values=np.nan)
    # a view from below shows middles of paws, the others their ends
    below = scene.geometry.from_below
    kinds_of_view = [
        learn_offsets(
            np.where(alike[:, None], clicks, np.nan), reference.found, paw_width_px=paw_width_px,
            facing=facing, limb_direction=scene.limb_direction, kinds=kinds,
        )
        for alike in (~below, below)
    ]  # fmt: skip
    offsets = [kinds_of_view[int(one)] for one in below]
    likelihood = AppearanceLikelihood(scene.limb_direction, paw_width_px)
    if not scene.is_learnt:
        likelihood = scene.geometry.learn_score(likelihood, clicks, reference.found)
    return Targets(
        kinds, certain, with_contralateral(layout.tracked, layout.kinds, extra),
        read_observations(recording.found, offsets, facing=facing, likelihood=likelihood),
        likelihood, np.max([one.unsure for one in offsets], axis=0),
        bool(unlabelled_kinds(layout.kinds)),
    )  # fmt: skip


def build_paths(recording: Recording, targets: Targets) -> TrackletAssociator:
    """Return the tracklets, to be chosen from.

    Parameters
    ----------
    recording : Recording
        What is given.
    targets : Targets
        The points.

    Returns
    -------
    TrackletAssociator
        Its paths go through where the detections of placed points meet.
    """
    scene, settings = recording.scene, recording.settings
    meet = {
        t: scene.geometry.anchors_of_paths(
            here, recording.found[t], targets.observations.only(t),
            most=settings.max_hypotheses, likelihood=targets.likelihood,
        )
        for t, here in recording.anchors.items()
    }  # fmt: skip
    return TrackletAssociator(
        recording.found, meet, scene, fps=recording.fps, settings=settings, kinds=targets.kinds,
        likelihood=targets.likelihood, tracked_in_view=targets.tracked_in_view,
    )  # fmt: skip
