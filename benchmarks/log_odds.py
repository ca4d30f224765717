"""Log-odds as sums of curves (logistic regression on linear splines), for what is learnt."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

Curves = Mapping[str, tuple[Sequence[float], Sequence[float]]]
"""Name of what is measured to knots, and values there."""

_STEPS = 25


def design(measured: Mapping[str, np.ndarray], curves: Curves) -> np.ndarray:
    """Return what each knot weighs for each row (n, knots of all curves); 0 where NaN."""
    parts = []
    for name, (knots, _) in curves.items():
        hats = np.eye(len(knots))
        parts += [np.nan_to_num(np.interp(measured[name], knots, hat)) for hat in hats]
    return np.column_stack(parts)


def fit(
    X: np.ndarray,
    y: np.ndarray,
    weight: np.ndarray,
    *,
    ridge: np.ndarray,
    before: np.ndarray | None = None,
) -> np.ndarray:
    """Return the values at the knots: Newton's method for the logistic regression.

    Parameters
    ----------
    X : ndarray, shape (n, k)
        The design.
    y : ndarray, shape (n,)
        What is so (1) and what is not (0).
    weight : ndarray, shape (n,)
        How much each row counts.
    ridge : ndarray, shape (k, k)
        What values cost: half of the square, in it, of how far they are from those before.
    before : ndarray, shape (k,), optional
        What is known of the values before; default 0.
    """
    before = np.zeros(X.shape[1]) if before is None else before
    b = before.copy()
    for _ in range(_STEPS):
        p = 1.0 / (1.0 + np.exp(-np.clip(X @ b, -30.0, 30.0)))
        H = (X * (weight * p * (1.0 - p))[:, None]).T @ X + ridge
        step = np.linalg.solve(H, X.T @ (weight * (y - p)) - ridge @ (b - before))
        b = b + step
        if np.abs(step).max() < 1e-6:
            break
    return b


def split(values: np.ndarray, curves: Curves) -> dict[str, np.ndarray]:
    """Return the values of each curve."""
    ends = np.cumsum([len(knots) for knots, _ in curves.values()])[:-1]
    return dict(zip(curves, np.split(values, ends), strict=True))


def print_curves(values: Mapping[str, np.ndarray], curves: Curves, *, decimals: int) -> None:
    """Print curves as they stand in the package."""
    print("CURVES = {")
    for name, heights in values.items():
        knots = ", ".join(f"{knot:g}" for knot in curves[name][0])
        # no minus before what is rounded to nothing
        told = ", ".join(f"{round(float(v), decimals) + 0.0:g}" for v in heights)
        print(f'    "{name}": (\n        ({knots}),\n        ({told}),\n    ),')
    print("}")
