"""Trial to Tracks in one call, and tracking again from a corrected frame."""

from __future__ import annotations

import contextlib
import dataclasses
import warnings
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pawnb.core.paws import PaperSettings, track_paws
from pawnb.core.paws.whole import WholeSettings, track_whole
from pawnb.core.rig import Rig, load_rig
from pawnb.core.video import ViewSet, open_views
from pawnb.errors import CalibrationError, InputError, InputWarning, did_you_mean
from pawnb.io import native
from pawnb.io.start import check_start, read_start
from pawnb.schema import Tracks, add_provenance, build_settings
from pawnb.trial import Trial, load_trial
from pawnb.workflow.progress import Progress, progress_bar
from pawnb.workflow.provenance import build_step, trial_checksums
from pawnb.workflow.results import describe_trial, provenance_steps, write_track_results

METHODS = ("pawnb", "paper", "slic-3d", "slic-2d")
"""Methods of the paw tracker; the first is the default."""

TrackerSettings = WholeSettings | PaperSettings
_SETTINGS: dict[str, type[TrackerSettings]] = {
    method: WholeSettings if method == "pawnb" else PaperSettings for method in METHODS
}


def track(
    trial: Trial | str | Path,
    *,
    method: str = METHODS[0],
    settings: Mapping[str, Any] | None = None,
    start: pd.DataFrame | None = None,
    frames: tuple[int, int] | None = None,
    out: str | Path | None = None,
    progress: Progress | None = None,
    stop: Callable[[], bool] | None = None,
    command: Sequence[str] | None = None,
) -> Tracks:
    """Track the points of a trial through its recording.

    Parameters
    ----------
    trial : Trial, str or Path
        The trial, its ``trial.toml``, or the folder that holds it.
    method : {"pawnb", "paper", "slic-3d", "slic-2d"}
        ``"pawnb"`` decides over the whole recording. ``"paper"``: superpixels, a 3D Kalman
        filter and a stride template, after Haji Maghsoudi et al. 2019; ``"slic-3d"`` and
        ``"slic-2d"`` are the lesser variants it is compared with: no template, and a 2D
        filter in each view.
    settings : mapping, optional
        Settings of the tracker; they go before those of ``[tracking]`` in the trial.
    start : pandas.DataFrame, optional
        Clicks with columns frame, view, point, u, v (px); default the trial's ``start.csv``.
    frames : tuple of int, optional
        Half-open range of frames; default the trial's, else from the first clicked frame on.
    out : str or Path, optional
        Folder for ``tracks.nc``, its tables, ``suspects.csv`` and ``provenance.json``.
    progress : callable, optional
        ``progress(done, total)``; default a bar on a terminal or in a notebook.
    stop : callable, optional
        Asked before each frame; when it answers True, what is done is kept.
    command : sequence of str, optional
        The command line, for the provenance.

    Returns
    -------
    xarray.Dataset
        Tracks; see :mod:`pawnb.schema`.

    Raises
    ------
    InputError
        If anything the trial names is missing or does not fit.
    """
    if not isinstance(trial, Trial):
        trial = load_trial(trial)
    if trial.kind != "paws":
        raise InputError(
            f"trial {trial.name!r} is of kind {trial.kind!r}; tracking needs kind 'paws'."
        )
    chosen = tracker_settings(trial, method=method, settings=settings)
    with open_views(trial) as views:
        for note in views.notes:
            warnings.warn(note, InputWarning, stacklevel=2)
        clicks = _start_clicks(trial, views, start)
        rig = trial_rig(trial, views)
        first, last = _frame_range(trial, views, clicks, frames)
        with _progress(progress, "tracking") as report:
            tracks = run_tracker(
                method,
                views,
                clicks,
                rig=rig,
                settings=chosen,
                points_by_view=points_by_view(trial, clicks),
                facing=view_facing(trial, rig),
                frames=(first, last),
                fps=trial.fps,
                individual=trial.animal.id,
                unit=rig.unit if rig is not None else "px",
                progress=report,
                stop=stop,
            )
        # where the rate varies these are the file's own time stamps
        times = views.time_s[tracks["frame"].to_numpy()]
    tracks = _in_real_units(tracks, trial, rig)
    tracks = describe_trial(tracks.assign_coords(time=times), trial)
    step = build_step(
        "track",
        command=command,
        # clicks that were handed over stand in the record themselves
        inputs=trial_checksums(trial, start=start is None),
        settings=dataclasses.asdict(chosen),
        method=method,
        frames=[first, last],
        start=clicks.to_dict(orient="records"),
    )
    tracks = add_provenance(tracks, **step)
    if out is not None:
        write_track_results(tracks, out, rig=rig)
    return tracks


def retrack(
    trial: Trial,
    tracks: Tracks,
    frame: int,
    *,
    progress: Progress | None = None,
    stop: Callable[[], bool] | None = None,
) -> Tracks:
    """Track on from a corrected frame, with every state of the tracker reset.

    Features, Kalman states and 3D points are learnt again from the positions in
    ``frame``; the rows before it stay as they are (2019 paper, section 3.1).

    Parameters
    ----------
    trial : Trial
        The trial of these tracks.
    tracks : xarray.Dataset
        Tracks with the corrections already applied.
    frame : int
        The corrected frame.
    progress, stop
        As for :func:`track`.

    Returns
    -------
    xarray.Dataset
        Tracks of the same frames.

    Raises
    ------
    InputError
        If the frame is not among those of the tracks.
    """
    known = tracks["frame"].to_numpy()
    if frame not in known:
        raise InputError(
            f"frame {frame} is not among the tracked frames {known[0]} to {known[-1]}."
        )
    made = [step for step in provenance_steps(tracks) if step["step"] == "track"]
    method = made[-1]["method"] if made else METHODS[0]
    settings = (
        tracker_settings(trial, method=method)
        if not made
        else build_settings(
            _SETTINGS[method], made[-1]["settings"], where="settings of these tracks"
        )
    )
    clicks = _clicks_of_frame(trial, tracks, frame)
    with open_views(trial) as views:
        rig = trial_rig(trial, views)
        with _progress(progress, "tracking again") as report:
            new = run_tracker(
                method,
                views,
                clicks,
                rig=rig,
                settings=settings,
                points_by_view=points_by_view(trial, clicks),
                facing=view_facing(trial, rig),
                frames=(int(frame), int(known[-1]) + 1),
                fps=trial.fps,
                individual=trial.animal.id,
                unit=rig.unit if rig is not None else "px",
                tracks=tracks,
                progress=report,
                stop=stop,
            )
    new = _in_real_units(new, trial, rig, since=int(np.flatnonzero(known == frame)[0]))
    new = describe_trial(new.assign_attrs(tracks.attrs).assign_coords(time=tracks["time"]), trial)
    step = build_step(
        "retrack",
        command=None,
        inputs=trial_checksums(trial, start=False),
        settings=dataclasses.asdict(settings),
        frame=int(frame),
        start=clicks.to_dict(orient="records"),
    )
    return add_provenance(new, **step)


def tracker_settings(
    trial: Trial, *, method: str = METHODS[0], settings: Mapping[str, Any] | None = None
) -> TrackerSettings:
    """Return the settings in force: the trial's ``[tracking]``, overridden by ``settings``.

    Parameters
    ----------
    trial : Trial
        The trial. Its ``[tracking]`` may hold settings of several methods.
    method : str
        A method of the tracker.
    settings : mapping, optional
        Settings of this method that go first; text is read as JSON where it can be.

    Returns
    -------
    WholeSettings or PaperSettings
        The settings.

    Raises
    ------
    InputError
        For an unknown method, an unknown setting, or a value of the wrong type.
    """
    if method not in METHODS:
        raise InputError(
            f"unknown method {method!r}{did_you_mean(method, METHODS)}; "
            f"expected {', '.join(METHODS)}."
        )
    kind = _SETTINGS[method]
    own = _setting_names(kind)
    others = set().union(*(_setting_names(other) for other in _SETTINGS.values())) - own
    given = {name: value for name, value in trial.tracking.items() if name not in others}
    build_settings(kind, given, where="trial.toml: [tracking]")
    for name in sorted(set(settings or {}) & others):
        owners = [other for other in METHODS if name in _setting_names(_SETTINGS[other])]
        raise InputError(
            f"setting {name!r} belongs to method {owners[0]!r}, not to {method!r}; leave it out, "
            f"or choose that method."
        )
    return build_settings(
        kind, {**given, **(settings or {})}, where=f"settings of method {method!r}"
    )


def _setting_names(kind: type[TrackerSettings]) -> set[str]:
    """Return the names of a method's settings."""
    return {f.name for f in dataclasses.fields(kind)}


def run_tracker(
    method: str, views: ViewSet, clicks: pd.DataFrame, *, settings: TrackerSettings, **options: Any
) -> Tracks:
    """Track with one of the methods.

    Parameters
    ----------
    method : str
        One of :data:`METHODS`.
    views : ViewSet
        The open views.
    clicks : pandas.DataFrame
        Start clicks.
    settings : WholeSettings or PaperSettings
        Settings of that method.
    **options
        The rest of what :func:`pawnb.core.paws.track_paws` takes.

    Returns
    -------
    xarray.Dataset
        Tracks.
    """
    if isinstance(settings, WholeSettings):
        return track_whole(views, clicks, settings=settings, **options)
    return track_paws(views, clicks, settings=settings, method=method, **options)


def trial_rig(trial: Trial, views: ViewSet) -> Rig | None:
    """Return the calibrated views of a trial, or None for a single uncalibrated one.

    Parameters
    ----------
    trial : Trial
        The trial.
    views : ViewSet
        Its open views, for the sizes of their pictures.

    Returns
    -------
    Rig or None
        None where there is one view without DLT coefficients.

    Raises
    ------
    CalibrationError
        If several views are to be tracked without a calibration.
    """
    sizes = {name: (r.source.width, r.source.height) for name, r in views.readers.items()}
    rig = load_rig(trial, sizes=sizes)
    if rig is None and len(trial.views) > 1:
        raise CalibrationError(
            f"trial {trial.name!r} has {len(trial.views)} views and no calibration; "
            'add [calibration] dlt = "DLTcoefs.csv" (11 rows, one column a view), '
            "or keep a single view."
        )
    return rig


def _in_real_units(tracks: Tracks, trial: Trial, rig: Rig | None, *, since: int = 0) -> Tracks:
    """Bring positions of a single view from px to the calibrated unit, from row ``since`` on."""
    calibration = trial.calibration
    if rig is not None or calibration is None or calibration.px_per_unit is None:
        return tracks
    scaled = tracks.assign_attrs(unit=calibration.unit)
    scaled["position"] = tracks["position"].copy(deep=True).assign_attrs(units=calibration.unit)
    scaled["position"].to_numpy()[since:] /= calibration.px_per_unit
    return scaled


def _clicks_of_frame(trial: Trial, tracks: Tracks, frame: int) -> pd.DataFrame:
    """Return a frame of Tracks as start clicks: what each view tracks and has a position for."""
    table = native.tracks_table(tracks.isel(time=tracks["frame"].to_numpy() == frame))
    tracked = np.array(
        [
            not view.points or point in view.points
            for view, point in zip(map(trial.view, table["view"]), table["point"], strict=True)
        ],
        dtype=bool,
    )
    known = table["u"].notna() & (table["origin"] != "reprojected")
    columns = ["frame", "view", "point", "u", "v"]
    return table.loc[known & tracked, columns].reset_index(drop=True)


def points_by_view(trial: Trial, clicks: pd.DataFrame) -> dict[str, tuple[str, ...]]:
    """Return the points each view tracks: those it names, else every clicked point."""
    every = tuple(dict.fromkeys(clicks["point"]))
    return {view.name: view.points or every for view in trial.views}


def view_facing(trial: Trial, rig: Rig | None) -> dict[str, int]:
    """Return +1 or -1 for each view in which the animal's direction is known."""
    facing = {view.name: view.facing for view in trial.views if view.facing is not None}
    if rig is not None:
        for name in rig.names:
            # a camera that looks along the animal's path sees it face neither way
            with contextlib.suppress(CalibrationError):
                facing.setdefault(name, rig.facing(name))
    return facing


def _start_clicks(trial: Trial, views: ViewSet, start: pd.DataFrame | None) -> pd.DataFrame:
    """Return the checked start clicks."""
    if start is None:
        file = trial.start_file()
        if file is None:
            raise InputError(
                f"trial {trial.name!r} has no start points; click them with "
                "pawnb.widgets.ClickInitialiser, or name a csv under [start] points."
            )
        start = read_start(trial.path(file), trial)
    sizes = {name: (r.width, r.height) for name, r in views.readers.items()}
    check_start(start, trial, sizes)
    return start


def _frame_range(
    trial: Trial, views: ViewSet, clicks: pd.DataFrame, frames: tuple[int, int] | None
) -> tuple[int, int]:
    """Return the half-open range of frames to track, checked against the recording."""
    first, last = frames or trial.frames or (int(clicks["frame"].min()), views.n_frames)
    first_click = int(clicks["frame"].min())
    if not 0 <= first < last <= views.n_frames:
        raise InputError(
            f"frames {first} to {last - 1} were asked for; the recording has frames 0 to "
            f"{views.n_frames - 1}: choose a range within."
        )
    if not first <= first_click < last:
        raise InputError(
            f"the start points were clicked in frame {first_click}, outside frames {first} to "
            f"{last - 1}; click a frame within, or change the range."
        )
    return first_click, last


def _progress(progress: Progress | None, label: str) -> Any:
    """Return a context that gives the caller's progress, or a bar of our own."""
    if progress is not None:
        return contextlib.nullcontext(progress)
    return progress_bar(label)
