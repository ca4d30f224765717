"""Gait of real rats on a treadmill, from the 2019 authors' own tracks.

    python benchmarks/rat_gait.py FOLDER

FOLDER holds their csv files (``rat-4cam-tracks`` of the test data). Printed for each trial:
residuals, belt speed, and for both ways to divide a stride (AEP and PEP; touch-down and
lift-off) the strides of each leg, frequency, duty factor and stride length, and the phases
of left to right and fore to hind legs, held against what is known of walking and trotting
rats: a few hertz, duty factor 0.5 to 0.8, left and right half a cycle apart.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pandas as pd

from pawnb.core.reconstruct import triangulate_tracks
from pawnb.core.rig import Rig
from pawnb.gait import analyse
from pawnb.io import authors2019
from pawnb.schema import Tracks
from pawnb.trial import Animal, Calibration, Trial

LEGS = ("FR", "HR", "FL", "HL")


def read(folder: Path, stamp: str) -> tuple[Tracks, pd.DataFrame]:
    """Read one trial, triangulate it, and read its belt."""
    rig = Rig(authors2019.VIEWS, authors2019.read_authors_dlt(_beside(folder, "dlt", stamp)))
    tracks = triangulate_tracks(
        authors2019.read_authors_trial(folder, stamp), rig, max_residual_px=20.0
    )
    return tracks, authors2019.read_authors_speed(_beside(folder, "speed_time", stamp))


def _beside(folder: Path, start: str, stamp: str) -> Path:
    """Find the DLT or speed file of a trial; upper and lower case vary."""
    return next(
        path
        for path in sorted(folder.glob("*.csv"))
        if path.name.lower().startswith(start) and stamp in path.name
    )


def measure_belt(tracks: Tracks) -> float:
    """Return the speed in mm/s at which feet on the belt are carried backwards.

    The median over the feet of the median speed along X while the foot is in the lowest
    tenth of its range of heights and moves backwards.
    """
    speeds = []
    for leg in LEGS:
        path = tracks["position"].sel(keypoint=leg).to_numpy()[..., 0]
        velocity = np.gradient(path[:, 0]) * tracks.attrs["fps"]
        low, high = np.nanpercentile(path[:, 2], [2, 98])
        down = (path[:, 2] < low + 0.1 * (high - low)) & (velocity < 0)
        speeds.append(-np.median(velocity[down]))
    return float(np.median(speeds))


def remove_below_belt(tracks: Tracks) -> int:
    """Set missing where a foot is 10 mm or more under the belt, and count these positions."""
    count = 0
    for leg in LEGS:
        height = tracks["position"].sel(keypoint=leg, space="z").to_numpy()[:, 0]
        wrong = height < np.nanmedian(height) - 10.0
        where = {"keypoint": leg, "time": tracks["time"].to_numpy()[wrong]}
        tracks["position"].loc[where] = np.nan
        count += int(wrong.sum())
    return count


def report(folder: Path, stamp: str) -> None:
    """Print everything about one trial."""
    tracks, belt = read(folder, stamp)
    residual = tracks["residual"].to_numpy()
    refused = authors2019.refused_rows(tracks)
    print(f"\n=== {stamp}: {tracks.sizes['time']} frames at {tracks.attrs['fps']:g} per s")
    print(
        f"residual: median {np.nanmedian(residual):.2f} px RMS over two views "
        f"({np.nanmedian(residual) * np.sqrt(2):.2f} px as DLTdv counts)"
    )
    rows = ", ".join(f"{name} {len(frames)}" for name, frames in refused.items())
    print(f"set missing: rows {rows or 'none'}; feet under the belt {remove_below_belt(tracks)}")
    used = belt[belt["frame"] <= int(tracks["frame"].to_numpy()[-1])]
    measured = measure_belt(tracks)
    print(
        f"belt: commanded {used['speed'].mean():.0f} mm/s ({used['speed'].min():.0f} to "
        f"{used['speed'].max():.0f}); feet on it are carried at {measured:.0f} mm/s "
        f"({measured / used['speed'].mean():.2f} times)"
    )
    for events in ("AEP", "TD"):
        report_gait(tracks, stamp, events, used[["frame", "speed"]], measured)


def report_gait(
    tracks: Tracks, stamp: str, events: str, commanded: pd.DataFrame, measured: float
) -> None:
    """Analyse with strides from one kind of event, at both belt speeds, and print it."""
    trial = Trial(
        kind="tracks", name=stamp, fps=tracks.attrs["fps"], animal=Animal(id="rat2"),
        calibration=Calibration(unit="mm"), tracks_file="tracks.nc",
    )  # fmt: skip
    tables, other = (
        analyse(tracks, trial=trial, legs=LEGS, belt_speed=belt, settings={"stride_events": events})
        for belt in (measured, commanded)
    )
    print(f"-- strides from {events} to {events}; mean ± SD; lengths in mm at the measured "
          "(commanded) belt speed")  # fmt: skip
    for leg in LEGS:
        own = tables.strides[tables.strides["leg"] == leg]
        lengths = other.strides.loc[other.strides["leg"] == leg, "stride_length"]
        print(
            f"   {leg}: {len(own):2d} strides  frequency {_spread(own['frequency_hz'])} Hz"
            f"  duty factor {_spread(own['duty_factor'])}"
            f"  stride length {_spread(own['stride_length'], 0)} ({_spread(lengths, 0)})"
        )
    for row in tables.phase_summary.itertuples():
        print(
            f"   phase {row.leg} to {row.reference}: n {row.n:2d}  mean {row.mean_strides:.2f}"
            f"  r {row.r_strides:.2f}  SD {row.circular_sd_strides:.2f}"
            f"  Rayleigh p {row.rayleigh_p_strides:.1g}"
        )
    what = tables.dropped.groupby(["what", "why"]).size()
    print("   dropped: " + ("; ".join(f"{n} × {a} ({b})" for (a, b), n in what.items()) or "-"))
    check(tables.strides, tables.phase_summary)


def check(strides: pd.DataFrame, phases: pd.DataFrame) -> None:
    """Hold medians against what is known of rats at these speeds."""
    beyond = []
    for leg, own in strides.groupby("leg"):
        frequency, duty = own["frequency_hz"].median(), own["duty_factor"].median()
        if not 1.0 <= frequency <= 5.0:
            beyond.append(f"{leg} {frequency:.1f} Hz")
        if not 0.5 <= duty <= 0.8:
            beyond.append(f"{leg} duty factor {duty:.2f}")
    for row in phases.itertuples():
        same_pair = row.leg[0] == row.reference[0]
        if same_pair and row.n >= 3 and not abs(row.mean_strides - 0.5) <= 0.1:
            beyond.append(f"{row.leg} to {row.reference} {row.mean_strides:.2f}")
    print("   outside what is known of rats: " + (", ".join(beyond) or "nothing"))


def _spread(values: pd.Series, decimals: int = 2) -> str:
    """Return mean ± SD as text."""
    if values.empty:
        return "-"
    sd = f" ± {values.std():.{decimals}f}" if len(values) > 1 else ""
    return f"{values.mean():.{decimals}f}{sd}"


def main() -> int:
    """Report every trial of the folder."""
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    folder = Path(sys.argv[1])
    for stamp in authors2019.list_authors_trials(folder):
        report(folder, stamp)
    return 0


if __name__ == "__main__":
    sys.exit(main())
