"""Joints in space over a recording, from poses in one view and the pictures of a second.

Pullar 2009, Eq. 5.1 sums the energy over views. Here the first view is the pose already tracked
in it, with its uncertainty across and along each leg; the second is painted and compared with
its own background. Segments have their lengths in space, so what is short in the first view must
rise or fall. Each frame is fitted alone first, every leg from an even arch; appearance and
proportions of the animal are learnt; frames take over their neighbours' heights where that
explains more; in the end heights are fitted with those of the frames beside.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Protocol

import numpy as np

from pawnb.arrays import FloatArray, IntArray
from pawnb.core import dlt
from pawnb.core.frame_checkpoint import KeptFrames
from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.fit.rendering.evidence import BackgroundPicture
from pawnb.core.pose.space.fitter import SpaceFitter, make_space_fitter
from pawnb.core.pose.space.frame import SpaceFrame, known_without_picture
from pawnb.core.pose.space.model import first_view_places, make_model
from pawnb.core.pose.space.parameters import IN_SPACE
from pawnb.core.pose.space.pipeline import (
    SpaceRecording,
    SpaceState,
    heights_beside,
    n_passes,
    run_space_pipeline,
)
from pawnb.core.pose.space.settings import SpaceSettings
from pawnb.core.pose.space.track import SpaceTrack
from pawnb.core.pose.track_result import PoseTrack
from pawnb.core.rig import Rig
from pawnb.core.video.views import Frame

_ALONG = 9
"""Numerics: places of a segment at which it is looked up whether it is shown."""


class Pictures(Protocol):
    """A view: its size, and its frames by their numbers in the trial."""

    width: int
    height: int

    def frame(self, index: int, /) -> Frame:
        """Return a frame."""


def place_in_space(
    reader: Pictures,
    track: PoseTrack,
    *,
    animal: StickAnimal,
    rig: Rig,
    views: tuple[str, str],
    first_size: tuple[int, int],
    background: BackgroundPicture,
    settings: SpaceSettings | None = None,
    rows: range | None = None,
    progress: Callable[[int, int], None] | None = None,
    stop: Callable[[], bool] | None = None,
    kept: KeptFrames | None = None,
) -> SpaceTrack:
    """Find the joints of a tracked animal in space with a second view.

    Parameters
    ----------
    reader : Pictures
        The second view.
    track : PoseTrack
        Poses in the first view; joints are found where it has one.
    animal : StickAnimal
        The animal.
    rig : Rig
        Calibration of both views.
    views : tuple of str
        The view of the track, and the second.
    first_size : tuple of int
        Width and height of the first view, px.
    background : Background
        The second view without the animal.
    settings : SpaceSettings, optional
        Settings; see there.
    rows : range, optional
        Rows of the track in which joints are wanted; default all. Appearance and proportions are
        learnt from frames of the whole track, so they are the same for any rows.
    progress : callable, optional
        Called with frames done and frames in all.
    stop : callable, optional
        Ends early where it returns True: frames not yet fitted stay NaN.
    kept : KeptFrames, optional
        What an interrupted run has found, and what this one finds, in all rows of the same track.

    Returns
    -------
    SpaceTrack
        One row for every frame of the track; NaN in those that are not wanted.

    Raises
    ------
    CalibrationError
        If a view is not calibrated, or both look in nearly the same direction.
    InputError
        If the second view does not show the animal.
    """
    settings = settings or SpaceSettings()
    model = make_model(
        animal,
        track,
        rig,
        views=views,
        sizes=(first_size, (reader.width, reader.height)),
        settings=settings,
    )
    known = np.flatnonzero(np.isfinite(track.poses.xy).all(axis=1))
    learn = known[_spread(len(known))]
    wanted = known if rows is None else np.intersect1d(known, rows)
    middle = reader.frame(int(track.poses.frames[known[len(known) // 2]]))
    fitter = make_space_fitter(model, background, middle)
    needed = np.union1d(learn, wanted)
    frames = _read_frames(reader, track, needed, fitter, stop=stop, progress=progress)
    if len(frames) < len(needed):  # stopped: some frames do not tell of all
        return _blank(len(track), model.layout.radius.shape)
    recording = SpaceRecording(
        frames=tuple(frames),
        numbers=track.poses.frames[needed],
        learn=np.flatnonzero(np.isin(needed, learn)).tolist(),
        wanted=np.flatnonzero(np.isin(needed, wanted)).tolist(),
        progress=progress,
        stop=stop,
        kept=kept or KeptFrames(),
    )
    return _result(run_space_pipeline(recording, fitter), len(track), needed)


def _read_frames(
    reader: Pictures,
    track: PoseTrack,
    needed: IntArray,
    fitter: SpaceFitter,
    *,
    stop: Callable[[], bool] | None,
    progress: Callable[[int, int], None] | None,
) -> list[SpaceFrame]:
    """Return what both views show of rows of the track, until stopped."""
    model, poses, frames = fitter.model, track.poses, []
    places, precision = first_view_places(model, track)
    for at, frame in _read(reader, poses.frames[needed], stop):
        k = needed[at]
        image, box = fitter.crop(frame, poses.xy[k], places=places[k], heights=model.heights)
        frames.append(
            SpaceFrame(
                xy=poses.xy[k],
                heading_deg=float(poses.heading_deg[k]),
                places=places[k],
                precision=precision[k],
                image=image.astype(np.float32),
                box=box,
            )
        )
        if progress is not None:
            progress(len(frames), n_passes() * len(needed))
    return frames


def _spread(n: int) -> list[int]:
    """Return some of n frames, over all of them."""
    return sorted({int(k) for k in np.linspace(0, n - 1, min(n, IN_SPACE.learn_from))})


def _read(
    reader: Pictures, numbers: Iterable[int], stop: Callable[[], bool] | None
) -> Iterator[tuple[int, Frame]]:
    """Yield frames with their place in ``numbers`` until stopped."""
    for row, number in enumerate(numbers):
        if stop is not None and stop():
            return
        yield row, reader.frame(int(number))


def _result(state: SpaceState, n: int, rows: IntArray) -> SpaceTrack:
    """Return what was found as rows of n; ``rows`` are those of the frames."""
    model, frames = state.fitter.model, state.recording.frames
    shape = frames[0].places.shape[:2]
    out = _blank(n, shape)
    padded = np.arange(shape[1]) > model.layout.n_segments[:, None]
    for k in state.recording.wanted:
        if not np.isfinite(state.cost[k]):
            continue  # stopped before it was fitted
        row = rows[k]
        one, x = frames[k], state.x[k]
        joints = np.where(padded[..., None], np.nan, x[1:].reshape(*shape, 3))
        sd = _deviations(state, k)
        out.body[row] = model.lines.at(one.xy, x[0])
        out.joints[row] = joints
        out.body_sd[row] = sd[0] * np.abs(model.lines.axis)
        out.joints_sd[row] = np.where(padded[..., None], np.nan, sd[1:].reshape(*shape, 3))
        out.support[row] = _support(state, k)
        both = dlt.project(np.column_stack([model.lines.coefs, model.coefs]), joints)
        out.residual_px[row] = np.linalg.norm(both[..., 0, :] - one.places, axis=-1)
        out.seen_uv[row] = both[..., 1, :] * model.factor + (model.factor - 1) / 2
        body = dlt.project(model.coefs, out.body[row])[0]
        out.body_uv[row] = body * model.factor + (model.factor - 1) / 2
    return out


def _deviations(state: SpaceState, k: int) -> FloatArray:
    """Return standard deviations of a frame's unknowns, by its pictures and the frames beside."""
    fitter, model, one = state.fitter, state.fitter.model, state.recording.frames[k]
    step = model.settings.height_step_share * model.span
    expected = heights_beside(state, k)
    known = known_without_picture(model, one, expected=expected, expected_sd=step)
    _, matrix, _ = fitter.equations(
        one, state.evidence(k), state.x[k], known=known, blur=fitter.blur
    )
    return np.asarray(np.sqrt(np.diag(np.linalg.inv(matrix))))


def _support(state: SpaceState, k: int) -> FloatArray:
    """Return the share of each leg's middle line on which the second view is dark."""
    layout, image_evidence = state.fitter.model.layout, state.evidence(k)
    *_, drawn = state.fitter.painted(state.recording.frames[k], image_evidence, state.x[k])
    height, width = image_evidence.seen.shape
    support = np.zeros(len(drawn))
    for i, n in enumerate(layout.n_segments):
        share = np.linspace(0.0, 1.0, _ALONG)[:, None, None]
        line = drawn[i, :n] + share * np.diff(drawn[i, : n + 1], axis=0)
        u, v = np.rint(line - image_evidence.box).astype(int).reshape(-1, 2).T
        inside = (u >= 0) & (v >= 0) & (u < width) & (v < height)
        least = IN_SPACE.shown_dark * layout.dark[i, :n]
        dark = np.repeat(least[None], _ALONG, axis=0).ravel()
        support[i] = (image_evidence.seen[v[inside], u[inside]] > dark[inside]).sum() / len(u)
    return support


def _blank(n: int, shape: tuple[int, int]) -> SpaceTrack:
    """Return a track of n frames without any joint."""
    return SpaceTrack(
        body=np.full((n, 3), np.nan),
        joints=np.full((n, *shape, 3), np.nan),
        body_sd=np.full((n, 3), np.nan),
        joints_sd=np.full((n, *shape, 3), np.nan),
        seen_uv=np.full((n, *shape, 2), np.nan),
        body_uv=np.full((n, 2), np.nan),
        residual_px=np.full((n, *shape), np.nan),
        support=np.full((n, shape[0]), np.nan),
    )
