"""The outline of the animal in one picture: its body without legs, and its limbs from the tips.

Nothing here knows a pose; :mod:`pawnb.core.pose.start_proposal.proposal` makes one of it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import cv2
import numpy as np

from pawnb.arrays import AnyArray, BoolArray, ByteArray, Float32Array, FloatArray, IntArray
from pawnb.core.pixels.grey import grey
from pawnb.core.pose.start_proposal.parameters import POSE_PROPOSAL


class BackgroundModel(Protocol):
    """What is asked of a :class:`pawnb.core.pose.background.Background`."""

    @property
    def mean(self) -> AnyArray:
        """Mean grey value of every pixel, (H, W)."""

    @property
    def sd(self) -> AnyArray:
        """Its standard deviation, (H, W)."""


@dataclass(frozen=True)
class Silhouette:
    """The animal's outline in one frame, on a grid that may be coarser than the picture.

    Parameters
    ----------
    mask : ndarray of bool, shape (h, w)
        Pixels of the animal.
    core : ndarray of bool, shape (h, w)
        Its body: the mask without its thin parts.
    depth : ndarray, shape (h, w)
        Distance to the nearest pixel outside the mask, grid px.
    ridge : ndarray, shape (h, w)
        Distance to the middle line of the nearest limb, grid px; 0 in the body.
    origin : tuple of int
        u, v of the grid's corner in the view, px.
    shrink : int
        px of the view along each side of a pixel of the grid.
    at_edge : bool
        Whether the animal touches the edge of the picture.
    others : float
        Area of the next largest thing in the picture, as a share of the animal's.
    """

    mask: BoolArray
    core: BoolArray
    depth: np.ndarray
    ridge: np.ndarray
    origin: tuple[int, int]
    shrink: int
    at_edge: bool
    others: float

    def to_view(self, points: FloatArray) -> FloatArray:
        """Return (..., 2) points u, v of the grid in px of the view."""
        offset = (self.shrink - 1) / 2
        return np.asarray(points, dtype=float) * self.shrink + offset + np.array(self.origin)

    def to_grid(self, points: FloatArray) -> FloatArray:
        """Return (..., 2) points u, v of the view in px of the grid."""
        offset = (self.shrink - 1) / 2
        return (np.asarray(points, dtype=float) - np.array(self.origin) - offset) / self.shrink


@dataclass(frozen=True)
class LimbOutline:
    """One limb: the way from its tip to the body.

    Parameters
    ----------
    path : ndarray, shape (n, 2)
        u, v from the body outwards to the tip, grid px.
    length : float
        Length of the path, grid px.
    own : float
        Length of the part that no longer limb shares, grid px.
    """

    path: FloatArray
    length: float
    own: float

    @property
    def tip(self) -> FloatArray:
        """u, v of the tip, grid px."""
        return self.path[-1]

    @property
    def root(self) -> FloatArray:
        """u, v where the limb leaves the body, grid px."""
        return self.path[0]


def sample_grid(grid: Float32Array, points: FloatArray) -> FloatArray:
    """Return a grid's values at (n, 2) points u, v, between its pixels; beyond it, its edge."""
    u = points[:, 0].astype(np.float32)[None]
    v = points[:, 1].astype(np.float32)[None]
    found = cv2.remap(grid, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(found[0], dtype=float)


def find_silhouette(image: ByteArray, background: BackgroundModel) -> Silhouette | None:
    """Find the animal's outline in one picture.

    Parameters
    ----------
    image : ndarray, shape (H, W) or (H, W, 3), uint8
        The picture.
    background : Background
        Mean and SD of the empty scene, each (H, W).

    Returns
    -------
    Silhouette or None
        None where nothing stands out from the background.
    """
    picture = grey(image)
    away = np.abs(picture - _light_change(picture, background.mean) * background.mean)
    away = cv2.GaussianBlur(away, (0, 0), POSE_PROPOSAL.blur_px)
    low, high = _thresholded(away, background)
    mask, others = _animal_of(low, high)
    if mask is None:
        return None
    v, u = np.nonzero(mask)
    height, width = mask.shape
    at_edge = bool(u.min() < 2 or v.min() < 2 or u.max() > width - 3 or v.max() > height - 3)
    box, shrink = _box_of(u, v, mask.shape)
    u0, v0, u1, v1 = box
    share, signal = mask[v0:v1, u0:u1].astype(np.float32), away[v0:v1, u0:u1]
    if shrink > 1:
        size = (share.shape[1] // shrink, share.shape[0] // shrink)
        share = np.asarray(cv2.resize(share, size, interpolation=cv2.INTER_AREA), np.float32)
        signal = cv2.resize(signal, size, interpolation=cv2.INTER_AREA)
    part = share > POSE_PROPOSAL.grid_share
    depth = cv2.distanceTransform(part.astype(np.uint8), cv2.DIST_L2, 5)
    core = _core_of(_sharp_depth(part, depth, signal))
    if not core.any():
        return None
    from skimage.morphology import skeletonize  # slow to import

    thin: Callable[[np.ndarray], np.ndarray] = skeletonize  # it comes without types
    lines = thin(part) & ~core
    ridge = cv2.distanceTransform((~(lines | core)).astype(np.uint8), cv2.DIST_L2, 5)
    return Silhouette(part, core, depth, ridge, (u0, v0), shrink, at_edge, others)


def trace_limbs(outline: Silhouette, *, shortest: float, most: int) -> list[LimbOutline]:
    """Find the limbs, the longest first: the farthest pixel from the body and its way there.

    Each next tip is the farthest pixel that no limb found before covers, as in the
    skeletons of Sato et al. 2000 (TEASAR).

    Parameters
    ----------
    outline : Silhouette
        The animal's outline.
    shortest : float
        Limbs with a shorter part of their own are not looked for, grid px.
    most : int
        Most limbs.

    Returns
    -------
    list of LimbOutline
        The limbs.
    """
    p = POSE_PROPOSAL
    window = np.ones((p.limb_window_px, p.limb_window_px))
    middle = outline.depth / np.maximum(cv2.dilate(outline.depth, window), 1e-6)
    cost = np.where(outline.mask, 1.0 + p.edge_cost * (1.0 - middle) ** 2, p.gap_cost)
    cost[outline.core] = p.body_cost  # the way may begin anywhere on the body
    from skimage.graph import MCP_Geometric  # slow to import

    walk = MCP_Geometric(cost)
    far, _ = walk.find_costs(np.argwhere(outline.core))
    open_ = outline.mask & ~outline.core & np.isfinite(far)
    limbs: list[LimbOutline] = []
    covered = cv2.dilate(outline.core.astype(np.uint8), np.ones((3, 3))).astype(bool)
    open_ &= ~covered
    while len(limbs) < most and open_.any():
        tip = np.unravel_index(np.argmax(np.where(open_, far, -1.0)), far.shape)
        way = np.array(walk.traceback(tip))  # from the body to the tip
        way = way[np.argmax(~outline.core[way[:, 0], way[:, 1]]) :]
        steps = np.hypot(*np.diff(way, axis=0).T) if len(way) > 1 else np.zeros(0)
        fresh = ~covered[way[:, 0], way[:, 1]]
        own = float(steps[fresh[1:]].sum())
        paint = np.zeros(far.shape, np.uint8)
        cv2.polylines(paint, [way[:, ::-1].astype(np.int32).reshape(-1, 1, 2)], False, 1)
        away = cv2.distanceTransform(1 - paint, cv2.DIST_L2, 5)
        usual = float(np.median(outline.depth[way[:, 0], way[:, 1]]))
        width = p.limb_width * usual + p.limb_width_px
        covered |= away <= width
        open_ &= ~covered
        if own >= shortest:
            limbs.append(LimbOutline(way[:, ::-1].astype(float), float(steps.sum()), own))
    return limbs


def _sharp_depth(part: np.ndarray, depth: np.ndarray, signal: np.ndarray) -> Float32Array:
    """Return the distance to the outline where it is sharp: half as far from the background.

    The mask reaches further, to where the picture begins to differ, so as to hold pale tips.
    """
    size = 2 * max(1, int(POSE_PROPOSAL.sharp_around * float(depth.max()))) + 1
    around = cv2.dilate(signal, cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size)))
    sharp = part & (signal > POSE_PROPOSAL.sharp_share * around)
    closed = cv2.morphologyEx(sharp.astype(np.uint8), cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8))
    return np.asarray(cv2.distanceTransform(closed, cv2.DIST_L2, 5))


def _thresholded(away: Float32Array, background: BackgroundModel) -> tuple[BoolArray, BoolArray]:
    """Return where the picture may be animal, and where it surely is."""
    p = POSE_PROPOSAL
    noise = max(float(np.median(background.sd)), p.noise_least)
    floor = p.noise_sds * np.sqrt(background.sd**2 + noise**2) * p.blur_noise
    candidates = away[away > np.maximum(floor, p.surely_animal * p.noise_sds * noise)]
    if candidates.size < p.pixels_least:
        empty = np.zeros(away.shape, dtype=bool)
        return empty, empty
    contrast = float(np.percentile(candidates, p.contrast_percentile))
    low = away > np.maximum(floor, p.pale * contrast)
    return low, low & (away > p.dark * contrast)


def _light_change(picture: Float32Array, mean: Float32Array) -> np.ndarray:
    """Return how much lighter each part of the scene is than it was, (H, W) about 1.

    The median ratio of blocks larger than the animal's parts, and of their neighbours: a
    shadow that sweeps over the scene changes many, the animal few.
    """
    height, width = mean.shape
    p = POSE_PROPOSAL
    size = max(p.light_block_px, min(height, width) // p.light_blocks)
    rows, columns = max(1, height // size), max(1, width // size)
    lit = mean > p.unlit_grey
    ratio = np.where(lit, picture / np.maximum(mean, 1.0), np.nan)[::2, ::2]
    whole = float(np.median(ratio[np.isfinite(ratio)])) if lit[::2, ::2].any() else 1.0
    blocks = np.full((rows, columns), whole, np.float32)
    for i, band in enumerate(np.array_split(ratio, rows)):
        for j, block in enumerate(np.array_split(band, columns, axis=1)):
            known = block[np.isfinite(block)]
            if known.size > p.light_known * block.size:
                blocks[i, j] = np.median(known)
    if min(rows, columns) >= 3:
        blocks = cv2.medianBlur(blocks, 3)
    return cv2.resize(blocks, (width, height), interpolation=cv2.INTER_LINEAR)


def _animal_of(low: BoolArray, high: BoolArray) -> tuple[BoolArray | None, float]:
    """Return the largest thing, with pieces beside it, and the size of the next as a share."""
    size = (POSE_PROPOSAL.closing_px, POSE_PROPOSAL.closing_px)
    joined = cv2.morphologyEx(low.astype(np.uint8), cv2.MORPH_CLOSE, np.ones(size, np.uint8))
    n, labels = cv2.connectedComponents(joined)
    areas = np.bincount(labels[high], minlength=n)
    areas[0] = 0
    if not areas.any():
        return None, 0.0
    order = np.argsort(areas)[::-1]
    others = float(areas[order[1]] / areas[order[0]]) if n > 2 else 0.0
    return low & (labels == order[0]), others


def _box_of(
    u: IntArray, v: IntArray, shape: tuple[int, int]
) -> tuple[tuple[int, int, int, int], int]:
    """Return a box round the pixels with a margin, a multiple of the factor to reduce it by."""
    longest = max(np.ptp(u), np.ptp(v)) + 1
    shrink = 1
    while longest / shrink > POSE_PROPOSAL.largest_px:
        shrink *= 2
    margin = POSE_PROPOSAL.margin_px * shrink
    height, width = shape
    u0, v0 = max(int(u.min()) - margin, 0), max(int(v.min()) - margin, 0)
    u1, v1 = min(int(u.max()) + margin + 1, width), min(int(v.max()) + margin + 1, height)
    return (u0, v0, u1 - (u1 - u0) % shrink, v1 - (v1 - v0) % shrink), shrink


def _core_of(depth: Float32Array) -> BoolArray:
    """Return the mask without its thin parts: opened by a disc, the largest piece."""
    radius = POSE_PROPOSAL.core_share * float(depth.max())
    seeds = (depth <= radius).astype(np.uint8)
    core = cv2.distanceTransform(seeds, cv2.DIST_L2, 5) < radius
    n, labels, stats, _ = cv2.connectedComponentsWithStats(core.astype(np.uint8))
    if n < 2:
        return core
    return labels == 1 + int(np.argmax(stats[1:, cv2.CC_STAT_AREA]))
