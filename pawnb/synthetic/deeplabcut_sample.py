"""Sample tracks as DeepLabCut writes them: mice on a treadmill seen from below, with truth."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

from pawnb.arrays import FloatArray
from pawnb.errors import InputError
from pawnb.io.tables import write_text

FPS = 200.0
BELT_PX_S = 600.0
_POINTS = {
    "snout": (150.0, 0.0), "tailbase": (-110.0, 0.0), "forepaw_R": (75.0, 32.0),
    "forepaw_L": (75.0, -32.0), "hindpaw_R": (-70.0, 38.0), "hindpaw_L": (-70.0, -38.0),
}  # fmt: skip
_LAGS = {"forepaw_R": 0.0, "forepaw_L": 0.5, "hindpaw_R": 0.55, "hindpaw_L": 0.05}
_LEGS = {"forepaw_R": "FR", "forepaw_L": "FL", "hindpaw_R": "HR", "hindpaw_L": "HL"}
_NETWORK = "DLC_resnet50_sample"


def write_deeplabcut_sample(
    folder: str | Path, *, animals: int = 6, seconds: float = 3.0, seed: int = 0
) -> list[Path]:
    """Write one csv an animal as DeepLabCut writes them, and ``truth.csv``.

    The mice trot on a treadmill at 600 px/s. Animals differ in period, duty factor and phases;
    strides of one animal differ less. Feet rest on the belt in stance. Points carry noise of
    1.5 px, a few are lost and jump, with a low likelihood.

    Parameters
    ----------
    folder : str or Path
        Where to write; made where it is absent.
    animals : int
        How many; half of them, the second group, have longer stances.
    seconds : float
        Length of each recording at 200 frames per second.
    seed : int
        Another seed is another sample.

    Returns
    -------
    list of Path
        The files, ``m01DLC.csv`` and so on. ``truth.csv`` beside them has animal, group,
        period_s, contact_duty_factor (touch-down to lift-off) and the phase of each leg.

    Raises
    ------
    InputError
        If there is no animal or no second.
    """
    if animals < 1 or not seconds >= 1.0:
        raise InputError(
            f"{animals} animals of {seconds:g} s; expected at least one animal of at least 1 s."
        )
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    rng = np.random.default_rng(seed)
    paths, truth = [], []
    for i in range(animals):
        name, late = f"m{i + 1:02d}", i >= (animals + 1) // 2
        period = 0.22 + 0.01 * rng.standard_normal()
        duty = (0.62 if late else 0.55) + 0.01 * rng.standard_normal()
        lags = {point: lag + 0.02 * rng.standard_normal() for point, lag in _LAGS.items()}
        table = _walk(rng, period, duty, lags, seconds)
        paths.append(folder / f"{name}DLC.csv")
        write_text(table.to_csv(lineterminator="\n"), paths[-1])
        row = {"animal": name, "group": "B" if late else "A", "period_s": period}
        row["contact_duty_factor"] = duty
        truth.append(row | {f"phase_{_LEGS[p]}": lag % 1.0 for p, lag in lags.items()})
    text = pd.DataFrame(truth).to_csv(index=False, lineterminator="\n")
    write_text(text, folder / "truth.csv")
    return paths


def _walk(
    rng: np.random.Generator, period: float, duty: float, lags: dict[str, float], seconds: float
) -> pd.DataFrame:
    """Return the table of one animal, with DeepLabCut's three lines of header."""
    t = np.arange(round(FPS * seconds)) / FPS
    sway = 6.0 * np.sin(2 * np.pi * t / 2.3 + rng.uniform(0, 6))
    columns: dict[tuple[str, str, str], np.ndarray] = {}
    for point, (along, across) in _POINTS.items():
        u = along + sway + 400.0
        if point in lags:
            u = u + _fore_aft(rng, t, period, duty, lags[point])
        sure = 1.0 - np.abs(0.02 * rng.standard_normal(len(t)))
        lost = rng.uniform(size=len(t)) < 0.004
        jump = np.where(lost, 80.0 * rng.standard_normal(len(t)), 0.0)
        sure = np.where(lost, rng.uniform(0.0, 0.3, len(t)), sure)
        noise = 1.5 * rng.standard_normal((2, len(t)))
        columns[_NETWORK, point, "x"] = u + noise[0] + jump
        columns[_NETWORK, point, "y"] = 200.0 + across + noise[1] - jump
        columns[_NETWORK, point, "likelihood"] = sure
    table = pd.DataFrame(columns).round(4)
    table.columns = table.columns.set_names(["scorer", "bodyparts", "coords"])
    return table


def _fore_aft(
    rng: np.random.Generator, t: FloatArray, period: float, duty: float, lag: float
) -> FloatArray:
    """Return where a foot is along the body: back with the belt, forward on a smooth swing."""
    n = int(t[-1] / period) + 4
    down = (np.arange(-2, n) + lag + 0.01 * rng.standard_normal(n + 2)) * period
    up = down + duty * period * (1 + 0.03 * rng.standard_normal(len(down)))
    front = BELT_PX_S * duty * period / 2.0
    k = np.searchsorted(down, t, side="right") - 1
    stance = front - BELT_PX_S * (np.minimum(t, up[k]) - down[k])
    s = np.clip((t - up[k]) / (down[k + 1] - up[k]), 0.0, 1.0)
    eased = s**3 * (10 - 15 * s + 6 * s**2)
    return stance + (front - stance) * eased
