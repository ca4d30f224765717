"""Build the stride template of the 2019 method from tracks.

    python -m pawnb.workflow.stride_template TRIAL ... [--tracks NAME] -o FILE

The template that comes with pawnb was made by this command from tracks of rendered scenes, by
method ``pawnb``. Give your own file to the tracker as the setting ``template``.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from pawnb.core.paws.maghsoudi2019.settings import Maghsoudi2019Settings
from pawnb.core.paws.maghsoudi2019.template import StrideTemplate, average_strides, cut_strides
from pawnb.core.rig import load_rig
from pawnb.errors import InputError, PawnbError
from pawnb.io.native import read_tracks
from pawnb.io.track_tables import read_tracks_table
from pawnb.kinematics import swing_direction
from pawnb.schema import Tracks, build_settings, each_of, make_tracks
from pawnb.trial import Trial, load_trial
from pawnb.workflow.conversion.foreign_tracks import read_foreign_tracks
from pawnb.workflow.tracking.trial_views import points_by_view, view_facing

TRACKS = "results/tracks.nc"
_SETTINGS = ("front", "hind", "template_cutoff_hz")


def build_template(
    trials: Sequence[Trial | str | Path], *, tracks: str | Path | Sequence[Tracks] = TRACKS
) -> StrideTemplate:
    """Build a stride template from the tracks of one or more trials.

    Parameters
    ----------
    trials : sequence of Trial, str or Path
        The trials: they say which view tracks which point, and where the animal faces; where
        neither they nor their calibration do, the paws' swings tell. Those of kind ``tracks``
        hold the tracks of other programs.
    tracks : str, Path, or sequence of xarray.Dataset
        The tracks of each trial, or the name of their file (``tracks.nc`` or ``tracks.csv``)
        relative to the folder of each trial. By default trials of kind ``tracks`` give their
        own.

    Returns
    -------
    StrideTemplate
        Mean strides of front and hind paws; write it with its ``save``.

    Raises
    ------
    InputError
        If a trial or its tracks cannot be read, or they hold no complete stride.
    """
    every = each_of(trials, what="trials", kinds=(str, os.PathLike, Trial))
    opened = [t if isinstance(t, Trial) else load_trial(t) for t in every]
    if isinstance(tracks, str | Path):
        given = [_read(trial, tracks) for trial in opened]
    else:
        given = list(tracks)
    if len(given) != len(opened):
        raise InputError(f"{len(opened)} trials and {len(given)} tracks; expected as many.")
    strides = []
    for trial, own in zip(opened, given, strict=True):
        # [tracking] may hold settings of other methods
        known = {name: trial.tracking[name] for name in _SETTINGS if name in trial.tracking}
        settings = build_settings(Maghsoudi2019Settings, known, where="trial.toml: [tracking]")
        own = _as_pictures(own)
        names = own["keypoint"].to_numpy().tolist()
        points = {name: settings.kind(name) for name in names if settings.kind(name) != "other"}
        tracked = points_by_view(trial, pd.DataFrame({"point": names})) if trial.views else None
        strides.append(
            cut_strides(
                own, points=points, points_by_view=tracked,
                facing=_facing(own, points, tracked) | view_facing(trial, load_rig(trial)),
                cutoff_hz=settings.template_cutoff_hz,
            )
        )  # fmt: skip
    return average_strides(strides)


def _read(trial: Trial, name: str | Path) -> Tracks:
    """Read tracks: netCDF, csv, or those that a trial of kind ``tracks`` names."""
    if trial.is_tracked_elsewhere and str(name) == TRACKS:
        return read_foreign_tracks(trial)
    path = trial.folder / name
    if path.suffix == ".csv":
        return read_tracks_table(path, fps=trial.fps, individual=trial.animal.id)
    return read_tracks(path)


def _as_pictures(tracks: Tracks) -> Tracks:
    """Return tracks of one picture, which other programs give as positions, with a view."""
    if "image_position" in tracks or tracks.sizes["space"] != 2:
        return tracks
    new = make_tracks(
        tracks["frame"].to_numpy(), tracks["keypoint"].to_numpy().tolist(),
        fps=float(tracks.attrs["fps"]), views=("picture",), space=("x", "y"),
    )  # fmt: skip
    new["image_position"][:, 0] = tracks["position"].isel(individual=[0]).to_numpy()
    new["image_origin"][:, 0] = tracks["origin"].isel(individual=[0]).to_numpy()
    return new


def _facing(
    tracks: Tracks, points: Iterable[str], tracked: Mapping[str, Sequence[str]] | None
) -> dict[str, int]:
    """Return where the animal faces in each view: to where its paws swing."""
    facing: dict[str, int] = {}
    for view in tracks["view"].to_numpy().tolist() if "view" in tracks.dims else ():
        names = [name for name in points if tracked is None or name in tracked.get(view, ())]
        uv = tracks["image_position"].sel(view=view, keypoint=names).isel(individual=0)
        known = uv.transpose("time", "image_space", "keypoint").to_numpy()
        known = known[:, :, np.isfinite(known[:, 0]).sum(axis=0) > 2]
        if known.shape[2]:
            forward = swing_direction(known, fs_hz=float(tracks.attrs["fps"]))[0]
            facing[view] = 1 if forward >= 0 else -1
    return facing


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; return 0, or 2 on bad input.

    Parameters
    ----------
    argv : sequence of str, optional
        Words of the command; default those of the command line.

    Returns
    -------
    int
        Exit status.
    """
    parser = argparse.ArgumentParser(
        prog="python -m pawnb.workflow.stride_template",
        description="Build the stride template of the 2019 method from tracks.",
    )
    parser.add_argument("trials", nargs="+", metavar="TRIAL", help="trial.toml, or its folder")
    parser.add_argument(
        "--tracks",
        default=TRACKS,
        help="file of each trial's tracks (default: %(default)s; "
        "of trials of kind tracks, the file that they name)",
    )
    parser.add_argument("-o", "--out", required=True, metavar="FILE", help="the JSON to write")
    options = parser.parse_args(argv)
    try:
        template = build_template(options.trials, tracks=options.tracks)
        template.save(options.out)
    except PawnbError as error:
        sys.stderr.write(f"{parser.prog}: {error}\n")
        return 2
    for kind, own in template.kinds.items():
        sys.stdout.write(f"{kind}: {own.n_strides} strides, mean {own.period_s:.3f} s\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
