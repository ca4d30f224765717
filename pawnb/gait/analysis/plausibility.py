"""What looks wrong in the strides of a trial: signs that something else than feet was followed."""

from __future__ import annotations

import math
from collections.abc import Iterator

import pandas as pd
from scipy.spatial.distance import pdist

from pawnb.gait.legs import find_leg_place

_LEAST_STRIDES = 3
_FREQUENCY_APART = 1.15
"""Legs of one animal step equally often; medians this many times apart are no chance."""

_STILL_OF_DISTANCE = 0.03
"""Feet move to and fro by half of the distance between them in a run, by a tenth in a shuffle."""

_DUTY_APART = 0.15
"""Contact begins after AEP and ends before PEP, in running mice by up to 0.12 of a stride."""

_AHEAD_OF_EXCURSION = 0.25
"""Of a stride's excursion, by which a hind leg steps ahead of the front leg of its side. Set by
hand: the middles of a mouse's steps lie half of one apart and more, the front one ahead."""

_EXCURSIONS_VARY = 0.28
_PERIODS_VARY = 0.4
"""Coefficients of variation within a leg, the median of legs. Strides that are jitter (white, of
10 % of the stride length and more) vary by 0.3 to 0.4 and 0.5 to 0.8; those of a fly that turns and
stops on a ball by 0.15 and 0.26."""

_FEW_FRAMES = 3.5
_SHORT_SHARE = 0.42
_FRAMES_OFF = 0.9
"""Swings of fewer frames come out too long: by 0.9 of a frame where 1.8 are found, 0.6 at 3, 0.4 at
4. Measured: minimum-jerk swings of known duration at 25 to 125 frames a second. Stances that are as
long do so, too, and then the duty factor is right."""

_FRAMES_ENOUGH = 12.0
_CONTACT_FRAMES_OFF = 1.0
"""Frames in a stride below which contact (TD to LO) is said to be too short, and by how many frames
at most. Measured on walks of known contact, duty factors 0.6 and 0.75, with swings that stop dead:
0.9 to 1.1 frames at 4 to 18 in a stride, which is 0.12 of a stride at 8, 0.07 at 12 and 0.04 at 50.
Real tracks of which every nth sample is taken lose 0.03 at 12 to 14 samples in a stride."""

_FRAMES_TOO_FEW = 5.0
"""Frames in a stride below which speed is too small as well: by up to 10 % at 4, 38 % at 3, in the
same walks. Duty factors of 0.35, 0.5, 0.65 and 0.75 come out as 0.50, 0.53, 0.56 and 0.59 at 3.75
frames in a stride, and as 0.51, 0.55, 0.59 and 0.62 at 4.6 (cycloid swings, 30 frames a second);
mean phases are right. Half the frame rate is the limit: what steps faster looks slower."""


def say_implausible(strides: pd.DataFrame, *, fps: float | None = None) -> list[str]:
    """Say what cannot be right in the strides of one animal in one trial.

    Parameters
    ----------
    strides : pandas.DataFrame
        Strides of one animal and trial, columns ``leg, frequency_hz, duty_factor`` and, where
        they are known, ``contact_duty_factor``, ``speed`` and ``excursion``, ``aep_position``,
        ``pep_position``, ``aep_lateral``, ``pep_lateral``.
    fps : float, optional
        Frames per second of the tracks that extremes were found in.

    Returns
    -------
    list of str
        One sentence each: where feet move by less than 3 % of the largest distance between them,
        where legs differ by more than 15 % in their median frequency, where the duty factors of a
        leg from AEP to PEP and from touch-down to lift-off differ by more than 0.15 and there are
        frames enough to tell, where the body goes backwards, where hind legs step ahead of the
        front legs of their side, where the strides of a leg are as unlike each other as jitter
        makes them, where swings (or stances) have so few frames that they come out too long, and
        where strides have so few that contact, or even speed, cannot be told.
    """
    frames = _frames_in_a_stride(strides, fps)
    return [
        *_still(strides), *_frequencies(strides),
        *([] if frames < _FRAMES_ENOUGH else _duties(strides)), *_backwards(strides),
        *_out_of_order(strides), *_unlike(strides),
        *_few_frames(strides, fps), *_few_in_a_stride(strides, frames),
    ]  # fmt: skip


def _still(strides: pd.DataFrame) -> Iterator[str]:
    """Name legs that hardly move: their strides are the jitter of the tracks."""
    if not {"excursion", "aep_position", "aep_lateral", "pep_lateral"} <= {*strides}:
        return
    across = (strides["aep_lateral"] - strides["pep_lateral"]).fillna(0.0)
    moved = (strides["excursion"] ** 2 + across**2).pow(0.5).groupby(strides["leg"], sort=False)
    places = strides.groupby("leg", sort=False)[["aep_position", "aep_lateral"]].median()
    apart = float(pdist(places.fillna(0.0)).max(initial=0.0))
    moves = moved.median()[moved.count() >= _LEAST_STRIDES]
    still = moves[moves < _STILL_OF_DISTANCE * apart]
    if len(still):
        whole = len(still) == len(moves)
        legs = ", ".join(map(str, still.index))
        yield (
            f"{legs} move{'s' * (len(still) == 1)} by {still.max() / apart:.1%} of the largest "
            "distance between the feet, or less, in a stride (median): "
            + ("the animal seems to stand still" if whole else "these feet seem to be held still")
            + ", and these strides to be the jitter of the tracks. Animals with many short legs "
            "may step so."
        )


def _frequencies(strides: pd.DataFrame) -> Iterator[str]:
    """Compare how often the legs step."""
    by_leg = strides.groupby("leg", sort=False)["frequency_hz"]
    median = by_leg.median()[by_leg.count() >= _LEAST_STRIDES]
    if len(median) > 1 and median.max() > _FREQUENCY_APART * median.min():
        yield (
            f"{median.idxmax()} makes {median.max():.3g} strides a second and {median.idxmin()} "
            f"{median.min():.3g}; legs "
            "of one animal step equally often: was another point than the foot followed, or "
            "does a leg lack strides (dropped.csv)?"
        )


def _duties(strides: pd.DataFrame) -> Iterator[str]:
    """Compare the two duty factors of each leg."""
    if "contact_duty_factor" not in strides:
        return
    known = strides.dropna(subset=["contact_duty_factor", "duty_factor"])
    found = []
    for leg, own in known.groupby("leg", sort=False):
        whole, contact = own["duty_factor"].mean(), own["contact_duty_factor"].mean()
        if len(own) >= _LEAST_STRIDES and abs(whole - contact) > _DUTY_APART:
            found.append(f"{leg} {whole:.2f} and {contact:.2f}")
    if found:
        yield (
            f"duty factors from AEP to PEP and from TD to LO are far apart ({'; '.join(found)}); "
            "check belt_speed, the direction (forward, facing) and what the animal runs on "
            "(substrate), and whether the feet themselves were followed."
        )


def _backwards(strides: pd.DataFrame) -> Iterator[str]:
    """Count strides in which the body goes backwards."""
    if "speed" not in strides:
        return
    backwards = int((strides["speed"] < 0.0).sum())
    if backwards:
        yield (
            f"{backwards} of {len(strides)} strides have a negative speed: the animal goes "
            "backwards, or it runs on a belt whose speed is not known (belt_speed, substrate), "
            "or forward is the wrong way round. Stance and swing, and duty_factor with them, are "
            "exchanged in these strides."
        )


def _out_of_order(strides: pd.DataFrame) -> Iterator[str]:
    """Say where the hindmost leg of a side steps ahead of the foremost one."""
    if not {"aep_position", "pep_position", "excursion"} <= {*strides}:
        return
    middle = (strides["aep_position"] + strides["pep_position"]) / 2
    by_leg = middle.groupby(strides["leg"].astype(str), sort=False)
    middles = by_leg.median()[by_leg.count() >= _LEAST_STRIDES]
    excursion = float(strides["excursion"].median())
    found, n_sides = [], 0
    for side in ("R", "L"):
        places = {leg: place for leg in middles.index if (place := find_leg_place(leg)) is not None}
        ranks = {leg: place.rank for leg, place in places.items() if place.side == side}
        if len(set(ranks.values())) < 2:
            continue
        n_sides += 1
        hind, front = max(ranks, key=ranks.__getitem__), min(ranks, key=ranks.__getitem__)
        share = float(middles[hind] - middles[front]) / excursion
        if share > _AHEAD_OF_EXCURSION:
            found.append(f"{hind} steps {share:.0%} of an excursion ahead of {front}")
    if found and len(found) == n_sides:
        yield (
            f"{' and '.join(found)} (median): are front and hind legs named the other way round, "
            "or is the direction of travel (forward, facing)? Phases and what is said of front and "
            "hind legs are those of the other ones then. An animal that goes backwards steps so."
        )


def _unlike(strides: pd.DataFrame) -> Iterator[str]:
    """Say where strides are unlike each other in length and duration, as those of jitter are."""
    if not {"excursion", "period_s"} <= {*strides} or not strides["excursion"].notna().any():
        return
    own = strides.groupby("leg", sort=False)[["excursion", "period_s"]]
    varies = (own.std() / own.mean())[own.count()["excursion"] > _LEAST_STRIDES]
    excursion, period = varies.median()
    if excursion > _EXCURSIONS_VARY and period > _PERIODS_VARY:
        yield (
            f"strides of one leg differ by {excursion:.0%} in excursion and {period:.0%} in "
            "period (coefficients of variation, the median of legs). Where the animal went "
            "steadily, many of them are the jitter of the tracks: look at the figures of the legs, "
            "and lower cutoff_hz or raise min_excursion."
        )


def _few_frames(strides: pd.DataFrame, fps: float | None) -> Iterator[str]:
    """Name legs whose swings, or stances, have too few frames to be told right."""
    by_position = strides[strides["method"] == "AEP/PEP"] if "method" in strides else strides[:0]
    if fps is None or by_position.empty:
        return
    median = by_position.groupby("leg", sort=False)[["swing_s", "stance_s", "period_s"]].median()
    for part, wrong in (("swing", "small"), ("stance", "large")):
        own = median[f"{part}_s"]
        short = median[(own * fps < _FEW_FRAMES) & (own < _SHORT_SHARE * median["period_s"])]
        if len(short):
            frames = fps * short[[f"{part}_s", "period_s"]].min()
            yield (
                f"{part}s of {', '.join(map(str, short.index))} have {frames.iloc[0]:.1f} frames "
                f"of {frames.iloc[1]:.3g} in a stride (median): so short ones come out up to "
                f"{_FRAMES_OFF} of a frame too long, and duty factors up to "
                f"{_FRAMES_OFF / frames.iloc[1]:.2f} too {wrong}, the more the shorter the "
                f"{part}. Differences in duty factor may be those of speed or of the frame rate; "
                "more frames a second tell."
            )


def _frames_in_a_stride(strides: pd.DataFrame, fps: float | None) -> float:
    """Return how many frames a stride has (median); infinite where events are no frames of ours."""
    if fps is None or not {"period_s", "method"} <= {*strides}:
        return math.inf
    periods = strides.loc[strides["method"] == "AEP/PEP", "period_s"]
    return math.inf if periods.empty else fps * float(periods.median())


def _few_in_a_stride(strides: pd.DataFrame, frames: float) -> Iterator[str]:
    """Say where strides have so few frames that contact, or even speed, cannot be told."""
    if frames < _FRAMES_TOO_FEW:
        yield (
            f"strides have {frames:.1f} frames (median): duty factors come out between 0.5 and 0.6 "
            "whatever they are, so that those of animals, legs or speeds cannot be compared; speed "
            "and stride length may come out a third too small, contact (TD to LO) far too short, "
            "and feet that step faster than half the frame rate look slower than they are, so that "
            "the stride frequency may be wrong altogether. Film at least "
            f"{_FRAMES_ENOUGH:.0f} frames a stride."
        )
    elif frames < _FRAMES_ENOUGH and strides.get("contact_s", pd.Series(dtype=float)).notna().any():
        yield (
            f"strides have {frames:.1f} frames (median): contact (TD to LO) comes out up to a "
            "frame too short, contact_duty_factor up to "
            f"{_CONTACT_FRAMES_OFF / frames:.2f} too small. Film at least "
            f"{_FRAMES_ENOUGH:.0f} frames a stride."
        )
