"""Joints in space over a recording, from poses in one view and the pictures of a second.

Pullar 2009, Eq. 5.1 sums the energy over views. Here the first view is the pose already tracked
in it, with its uncertainty across and along each leg; the second is painted and compared with
its own background. Segments have their lengths in space, so what is short in the first view must
rise or fall. Each frame is fitted alone first, every leg from an even arch; the animal's look and
proportions are learnt; frames take over their neighbours' heights where that explains more; in
the end heights are fitted with those of the frames beside.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import partial
from typing import Protocol

import numpy as np

from pawnb.core import dlt
from pawnb.core.frame_checkpoint import KeptFrames
from pawnb.core.parallel import THREADS, Threads
from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.fit.rendering.evidence import BackgroundPicture
from pawnb.core.pose.fit.rendering.gauss_newton_kernels import ImageEvidence
from pawnb.core.pose.space.fitter import SpaceFitter
from pawnb.core.pose.space.frame import SpaceFrame, known_without_picture
from pawnb.core.pose.space.learn import learn_model
from pawnb.core.pose.space.model import first_view_places, make_model
from pawnb.core.pose.space.parameters import IN_SPACE
from pawnb.core.pose.space.settings import SpaceSettings
from pawnb.core.pose.space.track import SpaceTrack
from pawnb.core.pose.track_result import PoseTrack
from pawnb.core.rig import Rig
from pawnb.core.video.views import Frame
from pawnb.errors import InputError

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
        Rows of the track in which joints are wanted; default all. Look and proportions are
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
    places, precision = first_view_places(model, track)
    middle = reader.frame(int(track.poses.frames[known[len(known) // 2]]))
    fitter = SpaceFitter(model, background, middle)
    needed = np.union1d(learn, wanted)
    frames = []
    for at, frame in _read(reader, track.poses.frames[needed], stop):
        k = needed[at]
        image, box = fitter.crop(frame, track.poses.xy[k], places=places[k], heights=model.heights)
        frames.append(
            SpaceFrame(
                xy=track.poses.xy[k],
                heading_deg=float(track.poses.heading_deg[k]),
                places=places[k],
                precision=precision[k],
                image=image.astype(np.float32),
                box=box,
            )
        )
        if progress is not None:
            progress(len(frames), _n_passes() * len(needed))
    if len(frames) < len(needed):  # stopped: some frames do not tell of all
        return _blank(len(track), places.shape[1:3])
    solver = _SpaceSolver(
        fitter,
        frames,
        track.poses.frames[needed],
        learn=np.flatnonzero(np.isin(needed, learn)).tolist(),
        wanted=np.flatnonzero(np.isin(needed, wanted)).tolist(),
        progress=progress,
        stop=stop,
        kept=kept or KeptFrames(),
    )
    solver.run()
    return solver.result(len(track), needed)


def _n_passes() -> int:
    """Return the passes over all frames: read, alone, from either side, and to settle."""
    return 4 + IN_SPACE.settle


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


class _SpaceSolver:
    """Fits all frames, again and again.

    Parameters
    ----------
    fitter : SpaceFitter
        The fitter; its model is learnt here.
    frames : list of SpaceFrame
        The frames.
    numbers : ndarray of int
        Their frame numbers.
    learn, wanted : list of int
        Which of them the model is learnt from, and which are to be fitted.
    progress, stop, kept
        As for :func:`place_in_space`.
    """

    def __init__(
        self,
        fitter: SpaceFitter,
        frames: list[SpaceFrame],
        numbers: np.ndarray,
        *,
        learn: list[int],
        wanted: list[int],
        progress: Callable[[int, int], None] | None,
        stop: Callable[[], bool] | None,
        kept: KeptFrames,
    ) -> None:
        self.fitter, self.frames, self.numbers = fitter, frames, numbers
        self.learn, self.wanted = learn, wanted
        self.progress, self.passes = progress, 1
        self.stop, self.kept = stop, kept
        self.x = np.zeros((len(frames), 1 + 3 * frames[0].places[..., 0].size))
        self.cost = np.full(len(frames), np.inf)

    def image_evidence(self, k: int) -> ImageEvidence:
        """Return what the second view shows of a frame."""
        return self.fitter.image_evidence(self.frames[k].image, self.frames[k].box)

    def run(self) -> None:
        """Fit all frames."""
        fitter = self.fitter
        some = self.learn
        ground = [fitter.ground_below(self.frames[k], self.image_evidence(k)) for k in some]
        if not np.isfinite(ground).any():
            raise InputError(
                "the second view shows nothing that differs from its background; look at the "
                "background and the order of the views."
            )
        first = fitter.model.layout
        fitter.model = fitter.model.changed(ground=float(np.nanmedian(ground)))
        for k in some:
            self._alone(k)
        for _ in range(2):
            samples = [(self.frames[k], self.image_evidence(k), self.x[k]) for k in some]
            fitter.model = learn_model(fitter, samples, first)
            for k in some:
                self._alone(k)
        passes: list[tuple[str, Callable[[int], None], list[int], int]] = [
            ("alone", self._alone, self.wanted, THREADS),
            # a frame may lie in the wrong valley where its neighbour does not
            ("after the frame before", partial(self._take_over, step=-1), self.wanted, 1),
            ("after the next frame", partial(self._take_over, step=1), self.wanted[::-1], 1),
        ]
        for one in passes:
            if not self._each(*one):
                return
        for turn in range(IN_SPACE.settle):
            # all from the heights before, so that the order of the threads does not tell
            settle = partial(self._settle, before=self.x.copy())
            if not self._each(f"settled {turn}", settle, self.wanted, THREADS):
                return

    def _each(self, name: str, work: Callable[[int], None], order: list[int], threads: int) -> bool:
        """Do something with frames that no earlier run has done; False where stopped."""
        way = f"in space, {name}"

        def one(k: int) -> bool:
            found = self.kept.recall(way, int(self.numbers[k]))
            if found is not None:
                self.x[k], self.cost[k] = found["x"], found["cost"]
            elif self.stop is None or not self.stop():
                work(k)
                return True
            return False

        with Threads(threads) as pool:
            for k, is_new in zip(order, pool.map(one, order), strict=True):
                if is_new:
                    found = {"x": self.x[k], "cost": float(self.cost[k])}
                    self.kept.keep(way, int(self.numbers[k]), found)
        self.passes += 1
        if self.progress is not None:
            self.progress(self.passes * len(self.frames), _n_passes() * len(self.frames))
        return self.stop is None or not self.stop()

    def _alone(self, k: int) -> None:
        """Fit one frame from even arches."""
        one, image_evidence = self.frames[k], self.image_evidence(k)
        known = known_without_picture(self.fitter.model, one, expected=None, expected_sd=1.0)
        start = self.fitter.guess(one, image_evidence)
        self.x[k], self.cost[k] = self.fitter.refine(
            one, image_evidence, start, known=known, coarse=True
        )

    def _take_over(self, k: int, *, step: int) -> None:
        """Fit one frame from the heights of the one beside, and keep what explains more."""
        other = k + step
        if not 0 <= other < len(self.x) or self.numbers[other] - self.numbers[k] != step:
            return
        one, image_evidence = self.frames[k], self.image_evidence(k)
        known = known_without_picture(self.fitter.model, one, expected=None, expected_sd=1.0)
        x, cost = self.fitter.refine(one, image_evidence, self._moved(other, k), known=known)
        if cost < self.cost[k]:
            self.x[k], self.cost[k] = x, cost

    def _moved(self, other: int, k: int) -> np.ndarray:
        """Return the unknowns of one frame moved to where the first view has another."""
        lines = self.fitter.model.lines
        joints = self.x[other, 1:].reshape(*self.frames[k].places.shape[:2], 3)
        slid = dlt.project(lines.coefs, joints)[..., 0, :] - self.frames[other].places
        moved = lines.at(self.frames[k].places + slid, lines.height(joints))
        return np.concatenate([self.x[other, :1], np.nan_to_num(moved).ravel()])

    def _settle(self, k: int, *, before: np.ndarray) -> None:
        """Fit one frame with the heights of the frames beside, as they were before."""
        model = self.fitter.model
        one, image_evidence = self.frames[k], self.image_evidence(k)
        step = model.settings.height_step_share * model.span
        expected = self._expected(k, before)
        known = known_without_picture(model, one, expected=expected, expected_sd=step)
        self.x[k], self.cost[k] = self.fitter.refine(one, image_evidence, self.x[k], known=known)

    def _expected(self, k: int, x: np.ndarray) -> np.ndarray | None:
        """Return the heights between those that unknowns ``x`` have in the frames beside."""
        beside = [
            j for j in (k - 1, k + 1)
            if 0 <= j < len(self.x) and abs(self.numbers[j] - self.numbers[k]) == 1
        ]  # fmt: skip
        if len(beside) < 2:
            return None
        return np.asarray(np.mean([self._heights(x[j]) for j in beside], axis=0))

    def _heights(self, x: np.ndarray) -> np.ndarray:
        """Return the heights of body and joints of a frame's unknowns."""
        joints = x[1:].reshape(-1, 3)
        return np.concatenate([x[:1], self.fitter.model.lines.height(joints)])

    def result(self, n: int, rows: np.ndarray) -> SpaceTrack:
        """Return what was found as rows of n; ``rows`` are those of the frames."""
        model = self.fitter.model
        shape = self.frames[0].places.shape[:2]
        out = _blank(n, shape)
        padded = np.arange(shape[1]) > model.layout.n_segments[:, None]
        for k in self.wanted:
            if not np.isfinite(self.cost[k]):
                continue  # stopped before it was fitted
            row = rows[k]
            one, x = self.frames[k], self.x[k]
            joints = np.where(padded[..., None], np.nan, x[1:].reshape(*shape, 3))
            sd, support = self._sureness(k)
            out.body[row] = model.lines.at(one.xy, x[0])
            out.joints[row] = joints
            out.body_sd[row] = sd[0] * np.abs(model.lines.axis)
            out.joints_sd[row] = np.where(padded[..., None], np.nan, sd[1:].reshape(*shape, 3))
            out.support[row] = support
            both = dlt.project(np.column_stack([model.lines.coefs, model.coefs]), joints)
            out.residual_px[row] = np.linalg.norm(both[..., 0, :] - one.places, axis=-1)
            out.seen_uv[row] = both[..., 1, :] * model.factor + (model.factor - 1) / 2
            body = dlt.project(model.coefs, out.body[row])[0]
            out.body_uv[row] = body * model.factor + (model.factor - 1) / 2
        return out

    def _sureness(self, k: int) -> tuple[np.ndarray, np.ndarray]:
        """Return standard deviations of a frame's unknowns, and the support of its legs."""
        fitter, model = self.fitter, self.fitter.model
        one, image_evidence = self.frames[k], self.image_evidence(k)
        step = model.settings.height_step_share * model.span
        expected = self._expected(k, self.x)
        known = known_without_picture(model, one, expected=expected, expected_sd=step)
        _, matrix, _ = fitter.equations(
            one, image_evidence, self.x[k], known=known, blur=fitter.blur
        )
        sd = np.sqrt(np.diag(np.linalg.inv(matrix)))
        _, _, _, drawn = fitter.painted(one, image_evidence, self.x[k])
        height, width = image_evidence.seen.shape
        support = np.zeros(len(drawn))
        for i, n in enumerate(model.layout.n_segments):
            share = np.linspace(0.0, 1.0, _ALONG)[:, None, None]
            line = drawn[i, :n] + share * np.diff(drawn[i, : n + 1], axis=0)
            u, v = np.rint(line - image_evidence.box).astype(int).reshape(-1, 2).T
            inside = (u >= 0) & (v >= 0) & (u < width) & (v < height)
            dark = np.repeat(
                IN_SPACE.shown_dark * model.layout.dark[i, :n][None], _ALONG, axis=0
            ).ravel()
            support[i] = (image_evidence.seen[v[inside], u[inside]] > dark[inside]).sum() / len(u)
        return sd, support


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
