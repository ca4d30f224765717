"""Exact minimum of an energy of binary labels on a grid of pixels: min-cut.

The energy is the sum of a cost for every pixel labelled 1 and of a cost, not below 0, for every
pair of neighbours (left and right, above and below) with different labels. Most pixels are decided
without a cut: where a pixel's own cost outweighs all its undecided neighbours together, its label
is known, and what it costs its neighbours to differ becomes part of their own cost. Only what
remains is cut, by scipy's maximum flow.

This exact reduction of the graph stands in place of the dynamic cuts that Pullar 2009, §5.1.3
wished for: those re-use the flow of the last cut where few costs have changed, but between two
frames every pixel's own cost changes with its noise, and what is left after the reduction is a
small part of the picture. The result does not depend on the cut before it.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import breadth_first_order, maximum_flow

from pawnb.arrays import BoolArray, Float32Array, IntArray
from pawnb.core.compiled import compiled

_MOST_FLOW = 2**30
"""Numerics: scipy's flows are 32-bit whole numbers; all flow together is scaled to this."""
_ROUNDED = 1.0001
"""Numerics: bounds are this much higher, so that rounding of sums does not decide."""


def cut_grid(own: Float32Array, right: Float32Array, down: Float32Array) -> BoolArray:
    """Return the labels of least energy.

    Parameters
    ----------
    own : ndarray, shape (H, W)
        Cost of label 1 less that of label 0.
    right : ndarray, shape (H, W - 1)
        Cost of different labels of a pixel and the one to its right; not below 0.
    down : ndarray, shape (H - 1, W)
        The same of a pixel and the one below.

    Returns
    -------
    ndarray of bool, shape (H, W)
        The labels. Of the pixels that are left to the cut, costs are rounded to a billionth of
        their sum; else the minimum is exact.
    """
    own, right, down = (np.ascontiguousarray(a, dtype=np.float32) for a in (own, right, down))
    label, rest = decide(own, right, down)
    open_pixels = np.flatnonzero(label.ravel() < 0)
    if len(open_pixels):
        label.ravel()[open_pixels] = _cut_rest(label, rest, right, down, open_pixels)
    return label.astype(bool)


def grid_energy(
    labels: BoolArray, own: Float32Array, *, right: Float32Array, down: Float32Array
) -> tuple[float, float]:
    """Return the energy of labels: the sum of pixels' own costs, and that of pairs.

    Parameters
    ----------
    labels : ndarray of bool, shape (H, W)
        The labels.
    own, right, down : ndarray
        As for :func:`cut_grid`.

    Returns
    -------
    float, float
        Own costs of the pixels labelled 1; costs of pairs with different labels.
    """
    pairs = right[labels[:, 1:] != labels[:, :-1]].sum(dtype=float)
    pairs += down[labels[1:] != labels[:-1]].sum(dtype=float)
    return float(own[labels].sum(dtype=float)), float(pairs)


def _cut_rest(
    label: IntArray, rest: Float32Array, right: Float32Array, down: Float32Array, at: IntArray
) -> IntArray:
    """Return the labels of the undecided pixels, by maximum flow."""
    n = len(at)
    number = np.full(label.shape, -1, np.int32)
    number.ravel()[at] = np.arange(n, dtype=np.int32)
    pairs = []
    for one, other, cost in (
        (number[:, :-1], number[:, 1:], right),
        (number[:-1], number[1:], down),
    ):
        both = (one >= 0) & (other >= 0)
        pairs.append((one[both], other[both], cost[both]))
    a, b, w = (np.concatenate(part) for part in zip(*pairs, strict=True))
    source, sink = n, n + 1
    own = rest.ravel()[at].astype(float)
    # a pixel that costs more as 1 hangs on the source, whose side is label 0
    total = max(own[own > 0].sum(), -own[own < 0].sum(), w.sum(dtype=float), 1e-30)
    scale = _MOST_FLOW / total
    pixel = np.arange(n)
    starts = np.concatenate([a, b, np.where(own > 0, source, pixel)])
    ends = np.concatenate([b, a, np.where(own > 0, pixel, sink)])
    caps = np.round(scale * np.concatenate([w, w, np.abs(own)])).astype(np.int32)
    graph = csr_array((caps, (starts, ends)), shape=(n + 2, n + 2))
    flow = maximum_flow(graph, source, sink).flow
    left = (graph - flow).tocsr()
    left.eliminate_zeros()
    reached = breadth_first_order(left, source, return_predecessors=False)
    labels = np.ones(n + 2, np.int8)
    labels[reached] = 0
    return labels[:n]


def decide(
    own: Float32Array, right: Float32Array, down: Float32Array
) -> tuple[IntArray, Float32Array]:
    """Return the labels that are certain without a cut, and the costs of the rest.

    Parameters
    ----------
    own, right, down : ndarray of float32
        As for :func:`cut_grid`.

    Returns
    -------
    label : ndarray of int8, shape (H, W)
        0 or 1 where a labelling of least energy has that label, -1 where it is undecided.
    rest : ndarray of float32, shape (H, W)
        Own costs with what the decided neighbours add.
    """
    height, width = own.shape
    frame = (height + 2, width + 2)
    rest, across, below = (np.zeros(frame, np.float32) for _ in range(3))
    rest[1:-1, 1:-1] = own
    across[1:-1, 1:-2] = right
    below[1:-2, 1:-1] = down
    label = np.zeros(frame, np.int8)
    label[1:-1, 1:-1] = -1
    _decide(label.ravel(), rest.ravel(), across.ravel(), below.ravel(), frame[1])
    return label[1:-1, 1:-1].copy(), rest[1:-1, 1:-1]


@compiled
def _decide(
    label: np.ndarray, rest: np.ndarray, across: np.ndarray, below: np.ndarray, width: int
) -> None:
    """Decide pixels with a work list; ``label`` and ``rest`` change. A frame of zeros is around."""
    todo = np.empty(label.size, np.int32)
    queued = label < 0
    bound = np.zeros_like(rest)
    n = 0
    for p in range(label.size - 1, -1, -1):
        if queued[p]:
            bound[p] = across[p] + across[p - 1] + below[p] + below[p - width]
            todo[n] = p
            n += 1
    while n > 0:
        n -= 1
        p = todo[n]
        queued[p] = False
        if abs(rest[p]) < bound[p] * np.float32(_ROUNDED):
            continue
        label[p] = 1 if rest[p] < 0 else 0
        for side in range(4):
            if side < 2:
                q = p + 1 if side == 0 else p - 1
                cost = across[min(p, q)]
            else:
                q = p + width if side == 2 else p - width
                cost = below[min(p, q)]
            if label[q] >= 0:
                continue
            bound[q] -= cost
            rest[q] += -cost if label[p] == 1 else cost
            if not queued[q]:
                queued[q] = True
                todo[n] = q
                n += 1
