"""Joint angles as signals of legs, to be cut into strides, averaged and compared."""

from __future__ import annotations

import re

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.errors import InputError
from pawnb.gait.cycles.leg_signals import LegSignals
from pawnb.gait.joints import JOINTS
from pawnb.gait.legs import sort_legs
from pawnb.schema import Tracks
from pawnb.schema.arguments import checked_arguments
from pawnb.signals import smooth_spline
from pawnb.signals.splines import LEAST_SAMPLES

JOINT_ANGLE = "joint angle"
_NAME = re.compile(r"(?P<leg>.+)_(?P<joint>[A-Z]+)")


@checked_arguments
def joint_signals(
    tracks: Tracks, *, animal: str | None = None, trial: str = "trial", smooth: bool = False
) -> list[LegSignals]:
    """Take the joint angles out of Tracks as signals: one for each joint, of all legs.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks with ``joint_angle`` (joints named ``<leg>_<joint>``), degrees.
    animal : str, optional
        Name to give the animal; default those of the Tracks, which may be several.
    trial : str
        Name of the trial, as in the strides.
    smooth : bool
        Smooth every joint over time by a spline (:func:`pawnb.signals.smooth_spline`). Means over
        many strides need it less than extremes do.

    Returns
    -------
    list of LegSignals
        From the body outwards: ``signal`` is ``"BC joint angle"`` and so on. Joints that never
        move (fixed ones) are left out; frames without a row are missing.

    Raises
    ------
    InputError
        If there is no joint angle, or several animals shall have one name.

    Examples
    --------
    >>> signals = pawnb.gait.cycles.joint_signals.joint_signals(tracks, trial=run.trial.name)
    """
    if "joint_angle" not in tracks:
        raise InputError(
            "joint angles: these tracks have no joint_angle; expected those of a jointed animal "
            "(kind 'pose')."
        )
    names = [str(name) for name in tracks["individual"].to_numpy()]
    if animal is not None and len(names) > 1:
        raise InputError(f"{len(names)} animals in these tracks shall be {animal!r}; give none.")
    frames = tracks["frame"].to_numpy().astype(int)
    every = np.arange(frames[0], frames[-1] + 1)
    time_s = every / float(tracks.attrs["fps"])
    values = tracks["joint_angle"].transpose("individual", "time", "joint").to_numpy()
    columns = [str(name) for name in tracks["joint"].to_numpy()]
    found = []
    for i, name in enumerate(names):
        angles = np.full((len(every), len(columns)), np.nan)
        angles[frames - frames[0]] = values[i]
        for joint, legs in _legs_by_joint(columns, angles).items():
            samples = angles[:, [columns.index(f"{leg}_{joint}") for leg in legs]]
            found.append(
                LegSignals(
                    animal=name if animal is None else animal, trial=trial, legs=tuple(legs),
                    time_s=time_s, samples=_smoothed(samples) if smooth else samples,
                    signal=f"{joint} {JOINT_ANGLE}", unit="deg",
                )
            )  # fmt: skip
    return found


def _legs_by_joint(columns: list[str], angles: FloatArray) -> dict[str, list[str]]:
    """Return the legs of each joint that moves, joints from the body outwards."""
    by_joint: dict[str, list[str]] = {}
    for k, column in enumerate(columns):
        found = _NAME.fullmatch(column)
        known = angles[np.isfinite(angles[:, k]), k]
        if found is not None and len(known) and np.ptp(known) > 0.0:
            by_joint.setdefault(found["joint"], []).append(found["leg"])
    order = [*JOINTS, *sorted(set(by_joint) - set(JOINTS))]
    return {joint: sort_legs(by_joint[joint]) for joint in order if joint in by_joint}


def _smoothed(samples: FloatArray) -> FloatArray:
    """Smooth each column that is long enough for a spline."""
    smoothed = samples.copy()
    for k in range(samples.shape[1]):
        if np.isfinite(samples[:, k]).sum() >= LEAST_SAMPLES:
            smoothed[:, k] = smooth_spline(samples[:, k], fs_hz=1.0)
    return smoothed
