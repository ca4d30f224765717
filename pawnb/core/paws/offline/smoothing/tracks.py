"""Smoothed tracks, the outcome of the decision over a recording."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np

from pawnb.arrays import AnyArray, BoolArray, FloatArray
from pawnb.core.paws.offline.smoothing.forward_backward_distance import NormalEquations


@dataclass(frozen=True)
class SmoothedTracks:
    """Smoothed tracks: n frames, P points, V views, d coordinates.

    Parameters
    ----------
    x, sd : ndarray, shape (n, P, d)
        Positions and their standard deviations.
    measured : ndarray, shape (n, P, V, 2)
        Detections taken, corrected by the offsets, NaN where none.
    detection_probability : ndarray, shape (n, P, V)
        How much each of them looks like the end of a paw, 0 to 1.
    displacement_from_first_pass : ndarray, shape (n, P)
        How far each position is from where an earlier decision had it, NaN where there was none.
    association_log_odds : ndarray, shape (n, P, V)
        How far detections are ahead of the next best ones (:mod:`.association_odds`), NaN where
        none.
    forward_backward_distance : ndarray, shape (n, P)
        How far a pass forwards and one backwards are apart (:mod:`.forward_backward_distance`), NaN
        where not known.
    equations : NormalEquations, optional
        What the tracks were smoothed from.
    """

    x: FloatArray
    sd: FloatArray
    measured: np.ndarray
    detection_probability: FloatArray
    displacement_from_first_pass: FloatArray
    association_log_odds: FloatArray
    forward_backward_distance: FloatArray
    equations: NormalEquations | None = None

    @classmethod
    def unknown(cls, n: int, n_points: int, n_views: int, d: int) -> SmoothedTracks:
        """Return tracks of which nothing is known.

        Parameters
        ----------
        n, n_points, n_views, d : int
            Numbers of frames, points, views and coordinates.

        Returns
        -------
        SmoothedTracks
            NaN everywhere, and no probability.
        """
        x, each = np.full((n, n_points, d), np.nan), np.full((n, n_points), np.nan)
        measured = np.full((n, n_points, n_views, 2), np.nan)
        none = np.zeros((n, n_points, n_views))
        return cls(x, x, measured, none, each, np.full(none.shape, np.nan), each)

    def points(self, which: AnyArray | slice) -> SmoothedTracks:
        """Return the tracks of some points, without what they were smoothed from."""
        return SmoothedTracks(*(getattr(self, name)[:, which] for name in _OF_POINTS))

    def within(self, reach: float) -> SmoothedTracks:
        """Return these tracks without what was only predicted, and lies further than any point can.

        Parameters
        ----------
        reach : float
            Largest distance of a point from the middle of the others that were found, as ``x``.

        Returns
        -------
        SmoothedTracks
            NaN where no view found a point and its prediction has left the animal.
        """
        found = np.isfinite(self.measured[..., 0]).any(axis=-1)
        away = np.full(found.shape, np.nan)
        for p in range(found.shape[1]):
            others = np.where(found[..., None], self.x, np.nan)
            others[:, p] = np.nan
            some = np.isfinite(others[..., 0]).any(axis=1)
            middle = np.nanmedian(others[some], axis=1)
            away[some, p] = np.linalg.norm(self.x[some, p] - middle, axis=-1)
        lost = (~found & (away > reach))[..., None]
        return replace(self, x=np.where(lost, np.nan, self.x), sd=np.where(lost, np.nan, self.sd))

    def with_points(self, which: BoolArray, tracks: SmoothedTracks) -> SmoothedTracks:
        """Return these tracks with those of the points that ``which`` (P,) picks out, in order.

        Parameters
        ----------
        which : ndarray of bool, shape (P,)
            Which points.
        tracks : SmoothedTracks
            Their tracks.

        Returns
        -------
        SmoothedTracks
            The tracks of all, without what they were smoothed from.
        """
        parts = []
        for name in _OF_POINTS:
            part = getattr(self, name).copy()
            part[:, which] = getattr(tracks, name)
            parts.append(part)
        return SmoothedTracks(*parts)


_OF_POINTS = tuple(field.name for field in fields(SmoothedTracks) if field.name != "equations")
"""What tracks have of every frame and point."""
