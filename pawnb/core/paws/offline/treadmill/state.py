"""What is known of the points between two steps of the pipeline."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.core.paws.offline.association.network_flow.assignment import Assignment
from pawnb.core.paws.offline.association.network_flow.tracklet_association import (
    TrackletAssociator,
)
from pawnb.core.paws.offline.gap_closing.state import GapClosing, TrackingState
from pawnb.core.paws.offline.smoothing.refinement import MeasurementModel
from pawnb.core.paws.offline.smoothing.tracks import SmoothedTracks
from pawnb.core.paws.offline.stride.learn import KnownGait
from pawnb.core.paws.offline.stride.model import StrideModel
from pawnb.core.paws.offline.treadmill.parameters import TREADMILL
from pawnb.core.paws.offline.treadmill.recording import Recording
from pawnb.core.paws.offline.treadmill.targets import Targets


@dataclass(frozen=True)
class PipelineState:
    """What is known; each step returns a new one.

    Parameters
    ----------
    recording : Recording
        What is given.
    targets : Targets
        The points.
    paths : TrackletAssociator
        The tracklets, to be chosen from.
    first : ndarray, shape (n, P, d)
        The first choice, by the clicks alone.
    assignment : Assignment
        Where points are by their paths.
    gap_closing : GapClosing
        What was taken where these are not certain.
    smoothed : SmoothedTracks
        The tracks.
    stride : StrideModel
        What is known of strides.
    before : ndarray, shape (n, P, d)
        The tracks of the pass before; NaN where there was none.
    unaided : ndarray, shape (n, P, d)
        The tracks before anything was known of strides; NaN until then.
    passes : int
        How often points were tracked.
    """

    recording: Recording
    targets: Targets
    paths: TrackletAssociator
    first: FloatArray
    assignment: Assignment
    gap_closing: GapClosing
    smoothed: SmoothedTracks
    stride: StrideModel
    before: FloatArray
    unaided: FloatArray
    passes: int = 0

    @classmethod
    def begin(
        cls, recording: Recording, targets: Targets, paths: TrackletAssociator, first: FloatArray
    ) -> PipelineState:
        """Return what is known before points are tracked: the first choice, and nothing else.

        Parameters
        ----------
        recording : Recording
            What was found in all frames.
        targets : Targets
            The points that are tracked.
        paths : TrackletAssociator
            Chooses tracklets for them.
        first : ndarray, shape (n, P, d)
            The first choice of places, NaN where occluded.

        Returns
        -------
        PipelineState
            The state.
        """
        by_hand = np.isfinite(targets.certain[..., 0]).any(axis=-1)
        n, n_points, n_views, most = targets.observations.at.shape[:4]
        nowhere = np.full(first.shape, np.nan)
        return cls(
            recording, targets, paths, first, Assignment(nowhere, by_hand),
            GapClosing(
                ~by_hand, np.full((n, n_points, n_views), -1),
                np.zeros((n, n_points, n_views, most)),
            ),
            SmoothedTracks.unknown(n, n_points, n_views, first.shape[2]),
            StrideModel(), nowhere, nowhere,
        )  # fmt: skip

    @property
    def known(self) -> TrackingState:
        """What gaps are closed by."""
        scene = self.recording.scene
        sd = self.smoothed.sd.mean(axis=-1) / scene.paw_width
        return TrackingState(
            self.assignment,
            self.smoothed.x,
            1.0 / (1.0 + (sd / TREADMILL.pipeline_believed) ** 2),
            self.stride,
            self.paths.body(self.assignment.at),
            self.targets.kinds,
            # by a learnt look, places of paws beside each other err by as much as these are apart
            not scene.is_learnt,
        )

    @property
    def measurement(self) -> MeasurementModel:
        """How well the views measure."""
        scene, targets = self.recording.scene, self.targets
        return MeasurementModel(
            scene.projection, scene.paw_width_px, scene.paw_width, self.paths.motion_model.jerk,
            targets.unsure,
        )  # fmt: skip

    @property
    def gait(self) -> KnownGait:
        """What is known of the points before their strides are."""
        recording, settings = self.recording, self.recording.settings
        return KnownGait(
            self.targets.kinds, self.targets.tracked_in_view, self.paths.motion_model,
            recording.fps, (settings.shortest_stride_s, settings.longest_stride_s),
        )  # fmt: skip
