"""Trial to Tracks in one call, and tracking again from a corrected frame."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from pawnb.core.paws.tracker import DEFAULT
from pawnb.schema import Tracks
from pawnb.schema.arguments import checked_arguments
from pawnb.trial import Trial, load_trial
from pawnb.workflow.kinds import kind_of
from pawnb.workflow.progress import Progress
from pawnb.workflow.tracking.options import RetrackOptions, TrackOptions


@checked_arguments
def track(
    trial: Trial | str | Path,
    *,
    method: str = DEFAULT,
    settings: Mapping[str, Any] | None = None,
    start: pd.DataFrame | None = None,
    frames: tuple[int, int] | None = None,
    out: str | Path | None = None,
    quick: bool = False,
    progress: Progress | None = None,
    stop: Callable[[], bool] | None = None,
    command: Sequence[str] | None = None,
) -> Tracks:
    """Track the points, or the pose, of a trial through its recording.

    Parameters
    ----------
    trial : Trial, str or Path
        The trial, its ``trial.toml``, or the folder that holds it.
    method : {"pawnb", "paper", "slic-3d", "slic-2d"}
        ``"pawnb"`` decides over the whole recording. ``"paper"``: superpixels, a 3D Kalman
        filter and a stride template, after Haji Maghsoudi et al. 2019; ``"slic-3d"`` and
        ``"slic-2d"`` are the lesser variants it is compared with: no template, and a 2D
        filter in each view. ``"slic-2d"`` alone tracks several views without a calibration:
        ``image_position`` has every view, and ``position`` is that in the first view in which
        the point was clicked, px.
    settings : mapping, optional
        Settings of the tracker; they go before those of ``[tracking]`` in the trial.
    start : pandas.DataFrame, optional
        Clicks with columns frame, view, point, u, v (px); default the trial's ``start.csv``.
        Of a jointed animal the columns of ``start_pose.csv``.
    frames : tuple of int, optional
        Half-open range of frames; default the trial's, else all. Method ``"pawnb"`` goes both
        ways from the clicks, as tracking a jointed animal does; the others begin with the first
        clicked frame and warn of what lies before it.
    out : str or Path, optional
        Folder for ``tracks.nc``, its tables, ``suspects.csv``, ``quality.json``,
        ``provenance.json`` and ``candidates.bin``. After an interruption a second run goes on
        from what is there.
    quick : bool
        Where points are found by what is learnt in the recording, and clicks were only added since
        the last run in this session: go on from that, which takes seconds, and track only what lies
        between the clicks on either side; where the pictures that it kept do not show what was
        clicked, others are read and all frames are tracked. A run from all clicks may be right
        more often (on one of three real clips 91 instead of 75 % of marks), and is what others can
        repeat.
    progress : callable, optional
        ``progress(done, total)``; default a bar on a terminal or in a notebook. One that takes
        ``doing``, too, is told in words what is done: "tracking", "deciding", or in a first run
        "compiling (first run only)".
    stop : callable, optional
        Asked before each frame; when it answers True, what is done is kept. By default an
        interrupt (Ctrl-C) does that. Called again with the same ``out``, it goes on from there.
        Method ``"pawnb"`` has tracks to show once it has come to the clicks.
    command : sequence of str, optional
        The command line, for the provenance.

    Returns
    -------
    xarray.Dataset
        Tracks; see :mod:`pawnb.schema`. With a calibration, points are shown also in the views
        that do not track them, re-projected from their place in space.
        :func:`pawnb.assess_quality` says how good they are; ``image_likeness`` is the correlation
        of the picture at a label with that at a click of the point, in a sample of frames.

    Raises
    ------
    InputError
        If anything the trial names is missing or does not fit.

    Warns
    -----
    QualityWarning
        If most labels are expected to be wrong.

    Examples
    --------
    >>> tracks = pawnb.track(trial, out="sample/results")
    >>> sorted(tracks["keypoint"].values.tolist())
    ['FL', 'FR', 'HL', 'HR']
    """
    if not isinstance(trial, Trial):
        trial = load_trial(trial)
    asked = TrackOptions(
        method=method, settings=settings, start=start, frames=frames, out=out, quick=quick,
        progress=progress, stop=stop, command=command,
    )  # fmt: skip
    return kind_of(trial).track(trial, asked)


@checked_arguments
def retrack(
    trial: Trial,
    tracks: Tracks,
    frame: int,
    *,
    learn: bool = False,
    out: str | Path | None = None,
    progress: Progress | None = None,
    stop: Callable[[], bool] | None = None,
) -> Tracks:
    """Track on from a corrected frame, with every state of the tracker reset.

    Features, Kalman states, 3D points, template fits and collision flags start anew
    from the positions in ``frame`` (2019 paper, section 3.1). Only the stretch that the
    correction touches is tracked again: each point put in place by hand in ``frame``, to
    the next frame in which that was done, or to where the new track has met the old one
    (within 2 px of the paper's pictures in every view, 10 frames in a row). Other points
    and all other rows stay as they are. Where nothing was put in place in ``frame``, all
    points are tracked again to the end.

    Method ``pawnb`` decides over the whole recording again, with everything that was put
    in place by hand as certain. Other points then take their new rows, too, about where
    they have moved: where one paw was taken for another, both are set right. Of tracks that were
    made by what was learnt in the recording only the frames up to the next click of the corrected
    points are looked at; what paws look like is learnt anew from the correction, too. Pictures and
    flow that this session has kept of the recording are not decoded again.

    Of a jointed animal see :func:`pawnb.workflow.tracking.pose.retrack_pose.retrack_pose`.

    Parameters
    ----------
    trial : Trial
        The trial of these tracks.
    tracks : xarray.Dataset
        Tracks with the corrections already applied.
    frame : int
        The corrected frame.
    learn : bool
        Learn the initial colours of the corrected points anew, from this frame on, as the
        paper's user may ask for. Without, they stay those of the start, and method
        ``pawnb`` decodes nothing that an earlier run has searched; where on a paw its point
        lies stays as clicked at the start, too. With it, method ``pawnb`` learns both from
        every position that was put in place by hand and searches the recording anew; what
        was learnt so stays when it is tracked again later.
    out : str or Path, optional
        Folder with the results of the earlier run; default ``results`` beside the trial.
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

    Examples
    --------
    >>> frame = int(tracks["frame"][30])
    >>> again = pawnb.retrack(trial, tracks, frame)
    >>> again.sizes["time"] == tracks.sizes["time"]
    True
    """
    asked = RetrackOptions(learn=learn, out=out, progress=progress, stop=stop)
    return kind_of(trial).retrack(trial, tracks, frame, asked=asked)
