"""What quality is measured of: labels, limits, and what a measure says of labels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pawnb.arrays import BoolArray, FloatArray
from pawnb.schema import ORIGIN_CODE

OF = ("place", "name")
"""What measures may doubt; see :class:`Measure`."""


@dataclass(frozen=True, kw_only=True)
class QualityLimits:
    """Absolute limits of what is right, good and failed.

    Parameters
    ----------
    good, failed : float
        Shares of labels that are expected to be right: ``good`` from the one on, ``failed`` below
        the other, between them ``look``. Set by hand.
    right : float
        Labels this near to the truth are right, in body sizes: half a paw. Measured: half a paw is
        0.035 to 0.1 of it in seven real clips with marks (horse, camel, dog, mice, fly), this in
        the middle.
    bridged_s : float
        Labels further than this from the next frame in which the point was found are not to be
        believed, s: a stance of a walking animal lasts a few tenths of a second, and what a paw did
        in a step that nobody saw is not known. Set by hand.
    beyond : float
        No point of an animal is further from the middle of the others, in body sizes; an animal may
        come nearer to the camera. Set by hand.
    leap : float
        No point moves so far in one frame, in body sizes. Measured: a leg tip of a fly at 100
        frames per second moves 0.25, a horse's hoof at 24 frames per second 0.3; twice that was set
        by hand.
    beside : float
        Points nearer than this, in body sizes, lie on one place. Set by hand.
    beside_s : float
        Paws that pass each other part again within this time, s. Set by hand.
    beside_in_space, beside_in_space_s : float
        In space they part within less. Measured: in truth, two paws of nine rendered scenes (two
        renderers) were nearer than 0.12 body sizes for 0.044 s at most, a front paw and the hind
        paw that lands beside it. No pair counts as one place at more than half the distance at
        which both were clicked.
    beside_of_a_kind_s : float
        Two front paws, or two hind paws, stand apart as far as the animal is wide. Measured: in
        six rendered scenes (two renderers) none came so near in any frame; where one was tracked
        on the other it lay there for 0.03 to 0.04 s in each of several swings.
    """

    good: float = 0.9
    failed: float = 0.5
    right: float = 0.055
    bridged_s: float = 0.3
    beyond: float = 1.25
    leap: float = 0.6
    beside: float = 0.03
    beside_s: float = 0.25
    beside_in_space: float = 0.12
    beside_in_space_s: float = 0.05
    beside_of_a_kind_s: float = 0.008


@dataclass(frozen=True)
class Measure:
    """One measure of labels.

    Parameters
    ----------
    words : str
        What speaks against a label; ``{point}`` and, where there is one, ``{other}``.
    left : ndarray, shape (n, V, P)
        What it leaves of the probability that a label is right, 0 to 1.
    other : ndarray of int, shape (n, V, P), optional
        Number of the other point that it is about.
    of : {"place", "name"}
        What is in doubt: how well the place is known, or whether it is this point that is there.
        Signs of the same doubt overlap.
    """

    words: str
    left: FloatArray
    other: FloatArray | None = None
    of: str = "place"


@dataclass(frozen=True)
class Labels:
    """What the measures need of tracks.

    Parameters
    ----------
    uv : ndarray, shape (n, V, P, 2)
        Image positions, px.
    origin : ndarray of int, shape (n, V, P)
        Their origins.
    body_px : ndarray, shape (V,)
        Size of the body; NaN where there is one point only.
    fps : float
        Frames per second.
    sizes : dict
        Width and height of views, px, by number, where they are known.
    space : ndarray, shape (n, P, 3)
        Positions in space; NaN without a calibration.
    clicked_apart : ndarray, shape (P, P)
        Smallest distance in space at which two points were clicked; NaN where they were not, or
        not in one frame.
    clicked : ndarray of bool, shape (n, P)
        Which points were clicked in a frame, in any view.
    kinds : tuple of str
        "front", "hind" or "other" for each point.
    """

    uv: FloatArray
    origin: FloatArray
    body_px: FloatArray
    fps: float
    sizes: dict[int, tuple[int, int]]
    space: FloatArray
    clicked_apart: FloatArray
    clicked: BoolArray
    kinds: tuple[str, ...]

    @property
    def found(self) -> BoolArray:
        """Which labels were found in the picture, or placed by hand."""
        return np.asarray(np.isin(self.origin, (ORIGIN_CODE["measured"], ORIGIN_CODE["edited"])))

    @property
    def known(self) -> BoolArray:
        """Which labels there are."""
        return np.asarray(np.isfinite(self.uv).all(axis=-1))


def in_views(values: FloatArray, labels: Labels) -> FloatArray:
    """Return values of frames and points, shape (n, P), for every view, shape (n, V, P)."""
    return np.broadcast_to(values[:, None], labels.origin.shape).copy()
