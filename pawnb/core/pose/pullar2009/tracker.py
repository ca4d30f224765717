"""The pose tracker of Pullar 2009, method ``paper``: frame by frame, both ways from the start."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Callable

import numpy as np

from pawnb.arrays import ByteArray, FloatArray
from pawnb.core.frame_checkpoint import KeptFrames
from pawnb.core.pixels.grey import grey
from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.poses import Poses, start_within
from pawnb.core.pose.pullar2009.energy import Pullar2009Energy
from pawnb.core.pose.pullar2009.inference import FramePose, infer_pose
from pawnb.core.pose.pullar2009.leg_lengths import fit_leg_lengths, per_segment, scaled
from pawnb.core.pose.pullar2009.likelihood import EmptyScene, background_cost
from pawnb.core.pose.pullar2009.parameters import PULLAR2009
from pawnb.core.pose.pullar2009.settings import Pullar2009Settings
from pawnb.core.pose.pullar2009.sticks import Sticks, distance_map, pose_vector
from pawnb.core.pose.track_result import PoseTrack, plain_track
from pawnb.core.video.views import ViewReader
from pawnb.errors import InputError, InputWarning
from pawnb.input_warnings import warn_of_input
from pawnb.schema import ORIGIN_CODE

_WAY = "one way"
"""A frame is come to from one start frame only."""


def track_pullar2009(
    reader: ViewReader,
    start: Poses,
    *,
    animal: StickAnimal,
    background: EmptyScene,
    settings: Pullar2009Settings | None = None,
    frames: tuple[int, int],
    reference: Poses | None = None,
    progress: Callable[[int, int], None] | None = None,
    stop: Callable[[], bool] | None = None,
    kept: KeptFrames | None = None,
) -> PoseTrack:
    """Track a jointed animal with the method of Pullar 2009, both ways from a start frame.

    Parameters
    ----------
    reader : ViewReader
        The view.
    start : Poses
        The animal's pose in one frame or more; those outside ``frames`` are left out.
        Frames between two poses are tracked from the nearer one.
    animal : StickAnimal
        The animal.
    background : Background
        The empty scene.
    settings : Pullar2009Settings, optional
        Settings; see there.
    frames : tuple of int
        First frame and one past the last.
    reference : Poses, optional
        One frame, also outside ``frames``, from which parameters are estimated (Table 3.3);
        default the first start pose. Its scale is kept throughout, and so are its segment lengths
        or, by default, how long each leg looks in that frame.
    progress : callable, optional
        Called with frames done and frames in all.
    stop : callable, optional
        Tracking ends early, with what it has, when this returns True.
    kept : KeptFrames, optional
        What an interrupted run has found frame by frame, and what this one finds.

    Returns
    -------
    PoseTrack
        One row for every frame of ``frames``: NaN and origin missing where the animal was not
        tracked. Confidence is the share of a leg's line on pixels labelled subject. The
        method knows no standard deviations. ``estimated`` are the parameters of the energy.

    Raises
    ------
    InputError
        If no start pose lies within ``frames``, it reaches outside the picture, or the animal
        is not there.

    Warns
    -----
    InputWarning
        If a leg reaches outside the picture: tracking ends there.

    Notes
    -----
    The guess in each frame is the pose before, moved on with the velocity between the two
    poses before it (§3.4.2).
    """
    settings = settings or Pullar2009Settings()
    numbers = np.arange(*frames)
    start = start_within(start, frames)
    start = dataclasses.replace(start, heading_deg=np.unwrap(start.heading_deg, period=360.0))
    reference = start.take([0]) if reference is None else reference
    tracker = _Tracker(
        reader, (start, reference), animal, background, settings, len(numbers),
        kept=kept or KeptFrames(),
    )  # fmt: skip
    tracker.run(frames, progress, stop)
    return tracker.result(numbers)


class _Tracker:
    """Keeps the energy, the poses found, and what is asked after each frame."""

    def __init__(
        self,
        reader: ViewReader,
        poses: tuple[Poses, Poses],
        animal: StickAnimal,
        background: EmptyScene,
        settings: Pullar2009Settings,
        total: int,
        *,
        kept: KeptFrames,
    ) -> None:
        self.reader, self.animal = reader, animal
        self.settings, self.total = settings, total
        self.starts, self.start = poses
        start = self.start
        picture = reader.frame(int(start.frames[0])).image()
        self.energy = Pullar2009Energy(
            animal, start, picture=picture, background=background, settings=settings
        )
        check_start(self.energy, picture, start)
        self.lengths_px = start.lengths_px[0]
        if settings.leg_lengths == "fitted":
            self._fit_lengths(picture)
        self.kept = kept
        self.found: dict[int, np.ndarray] = {}
        self.confidence: dict[int, np.ndarray] = {}

    def _fit_lengths(self, picture: np.ndarray) -> None:
        """Give the stick animal legs as long as they look in the start frame."""
        pose = pose_vector(self.start)
        slack = PULLAR2009.slack_of_span * self.energy.span_px
        frame = self.energy.frame(picture, pose, slack_px=slack)
        rng = np.random.default_rng(self.settings.seed)
        self.energy, factors = fit_leg_lengths(self.energy, frame, pose, rng=rng)
        self.lengths_px = self.lengths_px * per_segment(self.animal, factors)

    def run(
        self,
        frames: tuple[int, int],
        progress: Callable[[int, int], None] | None,
        stop: Callable[[], bool] | None,
    ) -> None:
        """Track each start frame, then forwards, then backwards, halfway to the next."""
        numbers = self.starts.frames.tolist()
        ends = [frames[0], *((a + b + 1) // 2 for a, b in itertools.pairwise(numbers)), frames[1]]
        for i in range(len(numbers)):
            one = self.starts.take([i])
            if numbers[i] != int(self.start.frames[0]):
                picture = self.reader.frame(numbers[i]).image()
                check_start(self.energy, picture, one)
            if not self._both_ways(one, (ends[i], ends[i + 1]), progress, stop):
                return
        if progress is not None:
            progress(self.total, self.total)

    def _both_ways(
        self,
        start: Poses,
        frames: tuple[int, int],
        progress: Callable[[int, int], None] | None,
        stop: Callable[[], bool] | None,
    ) -> bool:
        """Track a start frame and both ways from it; False where a person stopped it."""
        first = int(start.frames[0])
        begun = self._fit(first, pose_vector(start))
        for numbers, word in (
            (range(first + 1, frames[1]), "forwards"),
            (range(first - 1, frames[0] - 1, -1), "backwards"),
        ):
            before = last = begun
            for done, i in enumerate(numbers):
                if progress is not None:
                    progress(min(len(self.found), self.total), self.total)
                if stop is not None and stop():
                    return False
                leg = self._outside(last)
                if leg is not None:
                    warn_of_input(
                        f"frame {i - numbers.step}: {leg} reaches outside the picture; "
                        f"tracking {word} ends there, {len(numbers) - done} frames early.",
                        InputWarning,
                        stacklevel=3,
                    )
                    break
                before, last = last, self._fit(i, 2 * last - before)
        return True

    def result(self, numbers: np.ndarray) -> PoseTrack:
        """Return the track of all frames, NaN where there is none."""
        n, joints = len(numbers), len(self.animal.joints)
        vectors = np.full((n, 3 + joints), np.nan)
        confidence = np.zeros((n, len(self.animal.legs)))
        origin = np.full(confidence.shape, ORIGIN_CODE["missing"], dtype=np.int8)
        for row, i in enumerate(numbers):
            if int(i) in self.found:
                vectors[row], confidence[row] = self.found[int(i)], self.confidence[int(i)]
                seen = confidence[row] >= PULLAR2009.seen_share
                origin[row] = np.where(seen, ORIGIN_CODE["measured"], ORIGIN_CODE["predicted"])
        there = np.isfinite(vectors[:, 0])
        poses = Poses(
            frames=numbers,
            xy=vectors[:, :2],
            heading_deg=vectors[:, 2],
            scale=np.where(there, self.start.scale[0], np.nan),
            angles_deg=vectors[:, 3:],
            lengths_px=np.where(there[:, None], self.lengths_px, np.nan),
        )
        track = plain_track(self.animal, poses, confidence=confidence, origin=origin)
        estimated = dataclasses.asdict(self.energy.parameters)
        return dataclasses.replace(track, estimated=estimated)

    def _fit(self, number: int, guess: np.ndarray) -> np.ndarray:
        """Find the pose in a frame, where an earlier run has not."""
        known = self.kept.recall(_WAY, number)
        if known is None:
            fit, origin = self._infer(number, guess)
            known = {"pose": fit.pose, "confidence": _on_subject(self.energy, fit, origin)}
            self.kept.keep(_WAY, number, known)
        self.found[number], self.confidence[number] = known["pose"], known["confidence"]
        return self.found[number]

    def _infer(self, number: int, guess: np.ndarray) -> tuple[FramePose, tuple[int, int]]:
        """Fit a frame on a crop that is made anew while the animal leaves it.

        Returns the fit and the crop's first pixel.
        """
        picture = self.reader.frame(number).image()
        rng = np.random.default_rng([self.settings.seed, number])
        slack = PULLAR2009.slack_of_span * self.energy.span_px
        for _ in range(PULLAR2009.crops):
            frame = self.energy.frame(picture, guess, slack_px=slack)
            fit = infer_pose(self.energy, frame, guess, rng=rng)
            moved = np.abs(np.subtract(self.energy.extent(fit.pose), self.energy.extent(guess)))
            if moved.max() <= slack:
                break
            guess = fit.pose
        return fit, frame.box[:2]

    def _outside(self, pose: np.ndarray) -> str | None:
        """Return what part of the animal lies outside the picture, if any."""
        return part_outside(
            self.energy.sticks, pose, (self.reader.width, self.reader.height), animal=self.animal
        )


def check_start(energy: Pullar2009Energy, picture: ByteArray, start: Poses) -> None:
    """Refuse a start pose that is not on the animal or reaches outside the picture.

    Parameters
    ----------
    energy : Pullar2009Energy
        The energy, made of the start frame.
    picture : ndarray, shape (H, W) or (H, W, 3)
        The start frame.
    start : Poses
        The start pose.

    Raises
    ------
    InputError
        If the body's place differs from the background in less than half of its area, or
        part of the animal lies outside the picture.
    """
    where = f"the start pose of frame {start.frames[0]}"
    pose, height, width = pose_vector(start), picture.shape[0], picture.shape[1]
    raised = scaled(energy.sticks, np.full(len(energy.sticks.n_links), PULLAR2009.raised))
    part = part_outside(raised, pose, (width, height), animal=energy.animal)
    if part is not None:
        raise InputError(
            f"{where}: {part} reaches outside the picture ({width} x {height} px); start in "
            "a frame that shows the whole animal."
        )
    cost = background_cost(
        grey(picture), energy.background, sd_floor_grey=energy.settings.sd_floor_grey
    )
    stands_out = cost > cost.mean(dtype=float)
    sticks = energy.sticks
    nothing = np.empty((0, 2, 2)), np.empty(0, dtype=np.int64)
    body = distance_map((0, 0), cost.shape, pose[2], *nothing, sticks.parts(pose), 1.0) <= 0
    share = float(stands_out[body].mean())
    if share < PULLAR2009.body_share:
        u0, v0, u1, v1 = energy.parameters.subject_box
        raise InputError(
            f"{where} is not on the animal: only {100 * share:.0f} % of the body's place differs "
            f"from the background; something that does lies between ({u0}, {v0}) and "
            f"({u1 - 1}, {v1 - 1}) px: move the pose there."
        )


def part_outside(
    sticks: Sticks, pose: FloatArray, size: tuple[int, int], *, animal: StickAnimal
) -> str | None:
    """Return what lies outside a picture of that width and height: a leg's name, the body, or None.

    A leg may reach a little beyond the edge (``beyond_of_span``): the stick animal's legs do not
    shorten when they are raised. The body must be inside with its front and rear ends.

    Parameters
    ----------
    sticks : Sticks
        The stick animal as arrays.
    pose : ndarray
        The pose vector.
    size : tuple of int
        Width and height of the picture, px.
    animal : StickAnimal
        The animal, for the names of its legs.

    Returns
    -------
    str or None
        What lies outside.
    """
    beyond = PULLAR2009.beyond_of_span * 2 * float(sticks.length.sum(axis=1).max())
    low, high = -beyond, np.array(size) - 1 + beyond
    for name, line in zip(animal.leg_names, sticks.points(pose), strict=True):
        line = line[np.isfinite(line[:, 0])]
        if (line < low).any() or (line > high).any():
            return f"leg {name}"
    parts, turn = sticks.parts(pose), np.radians(pose[2])
    forward = parts[:, 2:3] * np.array([np.cos(turn), np.sin(turn)])
    ends = np.concatenate([parts[:, :2] + forward, parts[:, :2] - forward])
    return "the body" if (ends < 0).any() or (ends > np.array(size) - 1).any() else None


def _on_subject(energy: Pullar2009Energy, fit: FramePose, origin: tuple[int, int]) -> np.ndarray:
    """Return the share of each leg's line that lies on pixels labelled subject."""
    points, out = energy.sticks.points(fit.pose), []
    height, width = fit.cut.labels.shape
    for line, n in zip(points, energy.sticks.n_links, strict=True):
        steps = [
            np.linspace(line[i], line[i + 1], max(2, int(np.hypot(*(line[i + 1] - line[i])))))
            for i in range(n)
        ]
        u, v = np.round(np.concatenate(steps) - origin).astype(int).T
        inside = (u >= 0) & (v >= 0) & (u < width) & (v < height)
        hit = fit.cut.labels[v.clip(0, height - 1), u.clip(0, width - 1)] & inside
        out.append(hit.mean())
    return np.array(out)
