"""A study of synthetic spiders without pictures: tracks of many animals, and all that is true.

Animals differ in size, runs in speed, by laws that are known, so that the tables of Pullar 2009,
chapter 4, can be held against the truth.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from pawnb.arrays import FloatArray
from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.as_tracks import tracks_from_poses
from pawnb.core.pose.poses import Poses
from pawnb.core.pose.track_result import PoseTrack
from pawnb.errors import InputError
from pawnb.schema import ORIGIN_CODE, Tracks
from pawnb.synthetic.spider_motion import SpiderMotion
from pawnb.synthetic.spider_recording import SpiderRecording, record_spider
from pawnb.synthetic.spider_scene import (
    FPS,
    FULL_WIDTH,
    PX_PER_MM,
    SPECIES,
    SpiderScene,
    draw_individual,
    spider_scene,
)
from pawnb.synthetic.spider_truth import events_truth, phases_truth, pose_truth
from pawnb.trial import Animal, Calibration, Trial, View

_SIZE = 0.8
_SIZE_RANGE = (0.64, 1.0)
_SPEED_MM_S, _TRAVEL, _MASS_G = 155.0, 14.0, 1.0
"""Speed, way of the body over a standing foot (units of the species file) and mass at _SIZE."""

SPEED_EXPONENT = 0.72
"""Speed is as size to this power: 0.24 of mass."""
TRAVEL_EXPONENT = 0.2
"""Stride length relative to size is as speed to this power."""

_ANIMAL_SD = 0.08
_TRIAL_STEP = (0.08, 0.18)
_ENTER_MM = 110.0


@dataclass(frozen=True, eq=False)
class SpiderRun:
    """One run of one animal.

    Attributes
    ----------
    trial : Trial
        Name, frame rate, animal and scale.
    recording : SpiderRecording
        Everything that happened.
    events, phases, strides, pose : pandas.DataFrame
        The truth: ``EVENTS_COLUMNS`` and ``PHASES_COLUMNS`` of the continuous motion; strides
        with ``start_s, period_s, frequency_hz, stance_s, swing_s, duty_factor, speed`` (mm/s
        along the mean heading), ``stride_length`` (speed times period, mm), ``excursion_deg``,
        ``swing_velocity_deg_s, stance_velocity_deg_s, swing_distance``; and ``pose.csv``.
    """

    trial: Trial
    recording: SpiderRecording
    events: pd.DataFrame
    phases: pd.DataFrame
    strides: pd.DataFrame
    pose: pd.DataFrame

    def tracks(
        self, *, noise_px: float = 0.5, angle_noise_deg: float = 1.0, seed: int = 0
    ) -> Tracks:
        """Return what a tracker with white errors would have found.

        Parameters
        ----------
        noise_px : float
            Standard deviation of every coordinate of body, joints and tips, px.
        angle_noise_deg : float
            Standard deviation of every joint angle, degrees; that of the heading is a fifth.
        seed : int
            Another seed is another tracking of the same run.

        Returns
        -------
        xarray.Dataset
            Tracks in mm, as those of ``pawnb track`` on a jointed animal, in the frames with
            the whole animal in view.

        Raises
        ------
        InputError
            If a standard deviation is negative.
        """
        if not (0.0 <= noise_px < math.inf and 0.0 <= angle_noise_deg < math.inf):
            raise InputError(
                f"noise is {noise_px} px and {angle_noise_deg} degrees; expected 0 or more."
            )
        recording = self.recording
        scene, animal = recording.scene, recording.individual.animal
        rng = np.random.default_rng([scene.seed, seed, 11])
        poses = recording.poses.take(recording.whole)
        noisy = dataclasses.replace(
            poses,
            heading_deg=poses.heading_deg
            + 0.2 * angle_noise_deg * rng.standard_normal(poses.heading_deg.shape),
            angles_deg=poses.angles_deg
            + angle_noise_deg * rng.standard_normal(poses.angles_deg.shape),
        )
        true, found = (
            tracks_from_poses(
                animal, _sure(animal, one), fps=FPS, view="top", unit="mm",
                px_per_unit=scene.px_per_mm, individual=self.trial.animal.id,
            )
            for one in (poses, noisy)
        )  # fmt: skip
        # errors of angles do not add up along the legs: points are found in the picture
        away = noise_px * rng.standard_normal(true["image_position"].shape)
        image = true["image_position"] + away
        place = true["position"] + away[:, 0] / scene.px_per_mm
        return found.assign(image_position=image, position=place)


@dataclass(frozen=True, eq=False)
class SpiderStudy:
    """Runs of several animals.

    Attributes
    ----------
    runs : tuple of SpiderRun
        Animal by animal.
    animals : pandas.DataFrame
        ``animal, mass_g, body_length_mm``.
    """

    runs: tuple[SpiderRun, ...]
    animals: pd.DataFrame

    def truth(self, table: str) -> pd.DataFrame:
        """Return the true ``events``, ``strides`` or ``phases`` of all runs, one below another."""
        if table not in ("events", "strides", "phases"):
            raise InputError(f"truth of {table!r}; expected events, strides or phases.")
        return pd.concat([getattr(run, table) for run in self.runs], ignore_index=True)

    def true_angles(self) -> pd.DataFrame:
        """Return the true angles: ``animal, trial, leg, joint, angle_deg``, frame by frame."""
        parts = []
        for run in self.runs:
            joints = list(run.recording.individual.animal.joints)
            long = run.pose[joints].melt(var_name="name", value_name="angle_deg")
            long[["leg", "joint"]] = long["name"].str.split("_", n=1, expand=True)
            long.insert(0, "animal", run.trial.animal.id)
            long.insert(1, "trial", run.trial.name)
            parts.append(long)
        table = pd.concat(parts, ignore_index=True)
        return table[["animal", "trial", "leg", "joint", "angle_deg"]]


def true_exponents() -> Mapping[tuple[str, str], float]:
    """Return the exponents by which the animals of a study scale.

    Returns
    -------
    mapping
        (parameter, size) to exponent, for speed, relative_speed, frequency_hz and stride_length
        on mass and body_length. On mass they are those of Heglund et al. (1974) as printed in
        Pullar 2009, Table 4.4: 0.24, -0.14 and 0.38.
    """
    speed = SPEED_EXPONENT
    stride = 1.0 + TRAVEL_EXPONENT * speed
    on_length = {
        "speed": speed,
        "relative_speed": speed - 1.0,
        "frequency_hz": speed - stride,
        "stride_length": stride,
    }
    return {
        (name, size): value / (3.0 if size == "mass" else 1.0)
        for name, value in on_length.items()
        for size in ("mass", "body_length")
    }


def simulate_spider_study(
    *, animals: int = 15, trials: int = 2, seed: int = 0, difficulty: str = "normal"
) -> SpiderStudy:
    """Lay out the runs of a study, without rendering any picture.

    Parameters
    ----------
    animals : int
        Number of animals; the paper had 15.
    trials : int
        Runs an animal; the paper had 29 in all. They differ in speed.
    seed : int
        Another seed is another study.
    difficulty : {"easy", "normal", "hard"}
        How regular gait and foot places are; see
        :func:`pawnb.synthetic.spider_scene.spider_scene`.

    Returns
    -------
    SpiderStudy
        The runs, with their truth.

    Raises
    ------
    InputError
        If there is no animal or run, or for an unknown difficulty.

    Notes
    -----
    Body lengths are spread evenly on a logarithmic scale over a factor of 1.6; mass is as their
    cube. Speed and stride length follow :func:`true_exponents`, with 8 % scatter between animals;
    runs of an animal are 8 to 18 % apart from its mean. Stride length relative to size is as
    speed to the power 0.2. Phases are those of Pullar 2009, §4.2.4.
    """
    if animals < 1 or trials < 1:
        raise InputError(f"{animals} animals with {trials} runs; expected 1 or more of each.")
    base = spider_scene(difficulty, seed=seed)
    rng = np.random.default_rng([seed, 9, 21])
    sizes = np.geomspace(*_SIZE_RANGE, animals) if animals > 1 else np.array([_SIZE])
    runs, rows = [], []
    for i, size in enumerate(rng.permutation(sizes)):
        name = f"spider-{i + 1:02d}"
        own = np.exp(_ANIMAL_SD * np.clip(rng.standard_normal(), -1.5, 1.5))
        usual = _SPEED_MM_S * (size / _SIZE) ** SPEED_EXPONENT * own
        side = 1 if rng.random() < 0.5 else -1
        for k in range(trials):
            step = rng.uniform(*_TRIAL_STEP) * side * (-1) ** k * ((k + 2) // 2)
            speed = usual * math.exp(step)
            key = (seed * 1000 + i, seed * 1_000_000 + i * 1000 + k + 1)
            runs.append(_run(base, name, k + 1, size=float(size), speed=float(speed), key=key))
        length = runs[-1].recording.individual.animal.body_length * size
        rows.append((name, _MASS_G * (size / _SIZE) ** 3, length))
    table = pd.DataFrame(rows, columns=["animal", "mass_g", "body_length_mm"])
    return SpiderStudy(tuple(runs), table)


def _run(
    base: SpiderScene, animal: str, number: int, *, size: float, speed: float, key: tuple[int, int]
) -> SpiderRun:
    """Lay out one run; ``key`` seeds the animal and the run."""
    individual = draw_individual(dataclasses.replace(base, seed=key[0]))
    individual = dataclasses.replace(individual, size=size)
    travel = _TRAVEL * (speed / _SPEED_MM_S) ** TRAVEL_EXPONENT
    scene = dataclasses.replace(
        base, seed=key[1], speed_mm_s=(speed, speed), stance_travel=(travel, travel)
    )
    way = FULL_WIDTH / PX_PER_MM + _ENTER_MM
    recording = record_spider(scene, individual, math.ceil(way / speed * FPS))
    trial = Trial(
        kind="pose",
        name=f"{animal}-run-{number}",
        fps=FPS,
        animal=Animal(id=animal, species=SPECIES),
        views=(View(name="top", video="none.avi"),),
        calibration=Calibration(px_per_unit=scene.px_per_mm, unit="mm"),
    )
    whole = recording.poses.take(recording.whole)
    events = events_truth(
        recording.motion,
        fps=FPS,
        frames=(int(whole.frames[0]), int(whole.frames[-1])),
        animal=animal,
        trial=trial.name,
    )
    strides = strides_truth(recording.motion, events)
    return SpiderRun(
        trial, recording, events, phases_truth(events), strides,
        pose_truth(recording.individual.animal, whole),
    )  # fmt: skip


def strides_truth(motion: SpiderMotion, events: pd.DataFrame) -> pd.DataFrame:
    """Return the true strides of a run.

    Parameters
    ----------
    motion : SpiderMotion
        The run.
    events : pandas.DataFrame
        From :func:`pawnb.synthetic.spider_truth.events_truth`.

    Returns
    -------
    pandas.DataFrame
        The columns of :class:`SpiderRun`, one row a stride from AEP to AEP.
    """
    parts = []
    for leg, own in events.groupby("leg", sort=False):
        times = own.sort_values("time_s")
        aep = times.loc[times["event"] == "AEP", "time_s"].to_numpy()
        pep = times.loc[times["event"] == "PEP", "time_s"].to_numpy()
        start, end = aep[:-1], aep[1:]
        turn = pep[np.searchsorted(pep, start)] if len(start) else start
        angle = [motion.leg_angle(str(leg), t) for t in (start, turn, end)]
        period, stance = end - start, turn - start
        place, foot = motion.body.place, motion.feet[str(leg)].place
        moved = _along(motion, (start, end), place(end) - place(start))
        swung = _along(motion, (turn, end), (foot(end) - foot(turn))[..., :2])
        parts.append(
            pd.DataFrame(
                {
                    "animal": own["animal"].iloc[0], "trial": own["trial"].iloc[0], "leg": leg,
                    "stride": np.arange(1, len(start) + 1), "start_s": start,
                    "period_s": period, "frequency_hz": 1.0 / period, "stance_s": stance,
                    "swing_s": period - stance, "duty_factor": stance / period,
                    "speed": moved / period, "stride_length": moved,
                    "excursion_deg": angle[2] - angle[1],
                    "swing_velocity_deg_s": (angle[2] - angle[1]) / (end - turn),
                    "stance_velocity_deg_s": (angle[1] - angle[0]) / stance,
                    "swing_distance": swung,
                }
            )
        )  # fmt: skip
    return pd.concat(parts, ignore_index=True)


def _along(
    motion: SpiderMotion, times: tuple[FloatArray, FloatArray], way: FloatArray
) -> FloatArray:
    """Return the part of ways (n, 2) that lies along the heading between pairs of times, mm."""
    turn = np.radians(motion.body.heading((times[0] + times[1]) / 2.0))
    return np.asarray(way[..., 0] * np.cos(turn) + way[..., 1] * np.sin(turn))


def _sure(animal: StickAnimal, poses: Poses) -> PoseTrack:
    """Return poses as a tracker would that is sure of every leg."""
    n, legs = len(poses), len(animal.legs)
    segments = max(len(leg.segments) for leg in animal.legs)
    return PoseTrack(
        poses=poses,
        xy_sd_px=np.full((n, 2), np.nan),
        heading_sd_deg=np.full(n, np.nan),
        angles_sd_deg=np.full_like(poses.angles_deg, np.nan),
        places_sd_px=np.full((n, legs, segments + 1, 2), np.nan),
        confidence=np.ones((n, legs)),
        origin=np.full((n, legs), ORIGIN_CODE["measured"], dtype=np.int8),
    )
