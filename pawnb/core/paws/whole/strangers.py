"""Paws that a view shows but nobody clicked: those of the other side of the animal.

They look like the clicked ones and cross them in the picture. Followed as points of their
own, strangers, they are not taken for the clicked ones.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from pawnb.core.paws.whole.scene import Scene


def with_strangers(tracked: np.ndarray, kinds: Sequence[str], extra: Sequence[str]) -> np.ndarray:
    """Return which view tracks which point (P + S, V): strangers are seen like their kind.

    Parameters
    ----------
    tracked : ndarray of bool, shape (V, P)
        Which view tracks which clicked point.
    kinds, extra : sequence of str
        Kinds of the clicked points, and of the strangers.
    """
    alike = [tracked[:, [kind == own for kind in kinds]].any(axis=1) for own in extra]
    return np.stack([*tracked.T, *alike])


def nearer(
    x: np.ndarray,
    fixed: Mapping[int, Mapping[int, np.ndarray]],
    scene: Scene,
    *,
    kinds: Sequence[str],
    clicked: int,
) -> np.ndarray:
    """Exchange the paths of clicked points and strangers where those fit the clicks better.

    In space, a clicked point stays at the side where it was clicked. In a picture, what was
    clicked is on the near side of the animal, and what is near is lower in the picture.

    Parameters
    ----------
    x : ndarray, shape (n, P, d)
        Chosen places, NaN where hidden; strangers come last.
    fixed : mapping
        Frame to point number to position, certain.
    scene : Scene
        What the clicks say.
    kinds : sequence of str
        Kind of each point, "front" or "hind" for strangers.
    clicked : int
        Number of clicked points.

    Returns
    -------
    ndarray, shape (n, P, d)
        The places of the points that they belong to.
    """
    x = x.copy()
    for stranger in range(clicked, len(kinds)):
        point = kinds.index(kinds[stranger])
        if not np.isfinite(x[:, [point, stranger], 0]).any(axis=0).all():
            continue
        if scene.volume is None:
            away = [np.nanmedian(x[:, p] @ scene.up) for p in (point, stranger)]
        else:
            side = scene.volume.across
            click = np.mean([here[point] @ side for here in fixed.values() if point in here])
            away = [np.abs(np.nanmedian(x[:, p] @ side) - click) for p in (point, stranger)]
        if away[1] < away[0]:
            x[:, [point, stranger]] = x[:, [stranger, point]]
    for t, here in fixed.items():
        x[t] = np.nan
        for p, at in here.items():
            x[t, p] = at
    return x
