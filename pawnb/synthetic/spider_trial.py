"""A synthetic recording of a spider on disk: video, start pose and the truth."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import pandas as pd

from pawnb.core.pose.poses import Poses
from pawnb.errors import InputError
from pawnb.schema import EVENTS_COLUMNS
from pawnb.synthetic.grey_video import GreyVideoWriter
from pawnb.synthetic.spider_legs import LegBuilder
from pawnb.synthetic.spider_motion import SpiderMotion, plan_motion
from pawnb.synthetic.spider_paint import Shade, SpiderPainter
from pawnb.synthetic.spider_panel import Shadow, paint_panel, wall_rows
from pawnb.synthetic.spider_scene import (
    DRIFT_PX,
    EMPTY_FRAMES,
    FPS,
    FULL_WIDTH,
    PX_PER_MM,
    SHUTTER_S,
    SPECIES,
    Individual,
    SpiderScene,
    draw_individual,
    spider_scene,
)
from pawnb.synthetic.spider_truth import (
    events_truth,
    phases_truth,
    point_names,
    points_px,
    pose_truth,
    start_truth,
    tracks_truth,
    under_body,
)
from pawnb.trial import Animal, Calibration, Trial, View, save_trial

Progress = Callable[[int, int], None]

VIEW = "top"
_VIDEO = "spider.avi"
_MARGIN_MM = 2.5
"""What hairs, palps and the outline of the body add to the joints."""

_REFLECTION_MM = 11.0
"""How far from the wall its mirror image fades to a third."""


def render_spider_trial(
    folder: str | Path,
    *,
    frames: int = 120,
    scale: float = 0.5,
    seed: int = 0,
    difficulty: str = "normal",
    motion: str = "run",
    progress: Progress | None = None,
) -> Path:
    """Render a dark spider that runs over a light panel, seen from above, with its exact truth.

    Parameters
    ----------
    folder : str or Path
        Where to write; made if it is not there.
    frames : int
        Number of frames; the first 10 are empty.
    scale : float
        1 is 1280 x 1024 px, 4.84 px per mm, at 125 frames a second.
    seed : int
        Another seed is another animal, run and panel.
    difficulty : {"easy", "normal", "hard"}
        Contrast, noise, vignetting, grid and debris; paleness of the legs' tips; speed, how
        close feet come to each other and to the wall; a shadow that drifts over the panel.
    motion : {"run", "still", "drift"}
        A run through the picture; one posture held; or one posture that moves by 0.1 px of
        the rendered picture from frame to frame.
    progress : callable, optional
        Called with (frames done, frames in all).

    Returns
    -------
    Path
        ``trial.toml``, the last file that is written.

    Raises
    ------
    InputError
        For an unknown difficulty or motion, a scale or seed that makes no sense, or too few
        frames to hold the whole animal.

    Notes
    -----
    Files: ``spider.avi`` (grey Motion JPEG, quality 95), ``start_pose.csv`` (the truth of the
    first frame with the whole animal in view), ``trial.toml``, and in ``truth/``: ``pose.csv``
    and ``tracks.csv`` for the frames with any part of the animal in view (points ``body``,
    tips ``L1``, joints ``L1.BC``; ``visible`` is 1 in the picture and not under the body),
    ``events.csv`` (AEP and PEP: extremes of the total leg angle of the continuous motion,
    within the frames that show the whole animal) and ``phases.csv`` (Eq. 3.21).

    The true moment of a frame is the middle of its exposure. The camera looks straight down
    and has no perspective: a raised foot is seen where it is.
    """
    scene = spider_scene(difficulty, scale=scale, seed=seed, motion=motion)
    if frames < 2:
        raise InputError(f"frames is {frames}; expected 2 or more.")
    folder = Path(folder)
    individual = draw_individual(scene)
    recording = _record(scene, individual, frames)
    (folder / "truth").mkdir(parents=True, exist_ok=True)
    (folder / "trial.toml").unlink(missing_ok=True)
    _render_video(folder / _VIDEO, recording, progress)
    trial = _describe(folder, recording, difficulty)
    for name, table in _tables(recording, trial).items():
        table.to_csv(folder / name, index=False, lineterminator="\n")
    return save_trial(trial, folder / "trial.toml")


@dataclass(frozen=True)
class _Recording:
    """What happens in a recording.

    ``poses``, ``joints_px`` (n, moments, legs, segments + 1, 2) and ``bodies`` (n, moments, 3)
    are those of the n frames with the animal; the middle moment is the frame's. ``whole`` says
    in which of them all of it is in view.
    """

    scene: SpiderScene
    individual: Individual
    motion: SpiderMotion
    n_frames: int
    poses: Poses
    joints_px: np.ndarray
    bodies: np.ndarray
    whole: np.ndarray


def _record(scene: SpiderScene, individual: Individual, frames: int) -> _Recording:
    """Plan the run and lay out every frame."""
    motion = plan_motion(scene, individual, duration_s=frames / FPS)
    builder = LegBuilder(scene, individual)
    if scene.motion == "run":
        motion, times = _enter(scene, builder, motion, frames)
    else:
        motion, times = _hold(scene, builder, motion, frames)
    n, moments = times.shape
    posture = builder.posture(motion, times.ravel())
    px = posture.joints_mm[..., :2] * scene.px_per_mm - 0.5
    bodies = np.column_stack([posture.poses.xy, posture.poses.heading_deg])
    joints = px.reshape(n, moments, *px.shape[1:])
    bodies = bodies.reshape(n, moments, 3)
    poses = posture.poses.take(slice(moments // 2, None, moments))
    numbers = np.arange(frames)
    if scene.motion == "drift":
        turn = scene.rng(8).uniform(0, 2 * np.pi)
        step = DRIFT_PX * np.array([np.cos(turn), np.sin(turn)])
        drift = (numbers - EMPTY_FRAMES)[:, None] * step
        joints = joints + drift[:, None, None, None]
        bodies[:, :, :2] += drift[:, None]
        poses = dataclasses.replace(poses, xy=poses.xy + drift)
    poses = dataclasses.replace(poses, frames=numbers)
    inside, whole = _in_view(scene, individual, joints[:, moments // 2], poses)
    here = inside & (numbers >= EMPTY_FRAMES)
    if not (here & whole).any():
        raise InputError(
            f"in {frames} frames the animal is never wholly in view; render more, for instance 120."
        )
    return _Recording(
        scene, individual, motion, frames, poses.take(here), joints[here], bodies[here], whole[here]
    )


def _moments(scene: SpiderScene) -> int:
    """Return at how many moments of the exposure the animal is drawn."""
    if scene.motion == "still":
        return 1
    return 7 if scene.scale > 0.7 else 5


def _enter(
    scene: SpiderScene, builder: LegBuilder, motion: SpiderMotion, frames: int
) -> tuple[SpiderMotion, np.ndarray]:
    """Move the run so that its first foot comes into view just after the empty frames."""
    moments = _moments(scene)
    open_s = SHUTTER_S * ((np.arange(moments) + 0.5) / moments - 0.5)
    times = np.arange(frames)[:, None] / FPS + open_s
    before = builder.posture(motion, np.arange(EMPTY_FRAMES) / FPS)
    width = FULL_WIDTH / PX_PER_MM
    x = before.joints_mm[..., 0]
    towards = np.cos(np.radians(motion.body.heading_deg))
    by = -_MARGIN_MM - x.max() if towards > 0 else width + _MARGIN_MM - x.min()
    return motion.shifted(np.array([by, 0.0])), times


def _hold(
    scene: SpiderScene, builder: LegBuilder, motion: SpiderMotion, frames: int
) -> tuple[SpiderMotion, np.ndarray]:
    """Hold one posture of the run in the middle of the picture."""
    at = float(scene.rng(8).uniform(0.0, 0.5 * frames / FPS))
    width = FULL_WIDTH / PX_PER_MM
    x = builder.posture(motion, np.array([at])).joints_mm[..., 0]
    by = width / 2.0 - 0.5 * (x.min() + x.max())
    return motion.shifted(np.array([by, 0.0])), np.full((frames, 1), at)


def _in_view(
    scene: SpiderScene, individual: Individual, joints: np.ndarray, poses: Poses
) -> tuple[np.ndarray, np.ndarray]:
    """Return in which frames any part of the animal, and all of it, is in the picture."""
    turn = np.radians(poses.heading_deg)
    axis = np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    ends = [
        part.centre[0] + sign * part.length / 2
        for part in individual.animal.body
        for sign in (-1, 1)
    ]
    body = [poses.xy + poses.scale[:, None] * end * axis for end in ends]
    points = np.concatenate([joints.reshape(len(joints), -1, 2), np.stack(body, axis=1)], axis=1)
    low, high = points.min(axis=1), points.max(axis=1)
    margin = _MARGIN_MM * scene.px_per_mm
    size = np.array([scene.width, scene.height])
    inside = ((high > -margin) & (low < size - 1 + margin)).all(axis=1)
    return inside, ((low > 0) & (high < size - 1)).all(axis=1)


def _render_video(path: Path, recording: _Recording, progress: Progress | None) -> None:
    """Render all frames in order."""
    scene = recording.scene
    painter = SpiderPainter(scene, recording.individual)
    panel, shadow = paint_panel(scene), Shadow(scene)
    sensor = _Sensor(scene)
    row_of = {int(frame): row for row, frame in enumerate(recording.poses.frames)}
    held: Shade | None = None
    with GreyVideoWriter(path, size=(scene.width, scene.height), fps=FPS) as writer:
        for frame in range(recording.n_frames):
            picture = panel * shadow.light(frame / FPS)
            row = row_of.get(frame)
            if row is not None:
                shade = held or painter.paint(recording.joints_px[row], recording.bodies[row])
                held = shade if scene.motion == "still" else None
                _reflect(picture, shade, scene)
                _put(picture, shade)
            writer.write(sensor.expose(picture))
            if progress is not None:
                progress(frame + 1, recording.n_frames)


def _put(picture: np.ndarray, shade: Shade) -> None:
    """Put the animal in the picture, in place."""
    height, width = picture.shape
    rows = slice(max(shade.v0, 0), min(shade.v0 + shade.through.shape[0], height))
    columns = slice(max(shade.u0, 0), min(shade.u0 + shade.through.shape[1], width))
    if rows.start >= rows.stop or columns.start >= columns.stop:
        return
    part = (
        slice(rows.start - shade.v0, rows.stop - shade.v0),
        slice(columns.start - shade.u0, columns.stop - shade.u0),
    )
    picture[rows, columns] = picture[rows, columns] * shade.through[part] + shade.own[part]


def _reflect(picture: np.ndarray, shade: Shade, scene: SpiderScene) -> None:
    """Add the animal's mirror images in the glass walls, in place: fainter further from them."""
    width = shade.through.shape[1]
    for wall, beyond in zip(wall_rows(scene), (-1, 1), strict=True):
        reach = int(2.5 * _REFLECTION_MM * scene.px_per_mm)
        v0 = int(np.ceil(wall)) if beyond > 0 else int(np.floor(wall)) - reach + 1
        rows = np.arange(v0, v0 + reach)
        # row v of the mirror image shows row 2 wall - v of the animal
        matrix = np.array([[1.0, 0.0, 0.0], [0.0, -1.0, 2 * wall - v0 - shade.v0]])
        stopped = cv2.warpAffine(
            1.0 - shade.through, matrix, (width, reach), flags=cv2.INTER_LINEAR
        )
        fade = np.exp(-np.abs(rows - wall) / (_REFLECTION_MM * scene.px_per_mm))
        image = 1.0 - scene.reflection * fade[:, None] * stopped
        mirrored = Shade(shade.u0, v0, image.astype(np.float32), np.zeros_like(stopped))
        _put(picture, mirrored)


class _Sensor:
    """Light to grey levels of 8 bits."""

    def __init__(self, scene: SpiderScene) -> None:
        self._scene = scene
        self._rng = scene.rng(10)
        size = (scene.height, scene.width)
        # each pixel's own offset, which does not change
        self._offset = (0.3 * scene.read_noise * self._rng.standard_normal(size)).astype(np.float32)

    def expose(self, picture: np.ndarray) -> np.ndarray:
        """Return one frame (h, w) uint8."""
        scene = self._scene
        lamp = 1.0 + scene.flicker * self._rng.standard_normal()
        light = np.float32(lamp) * picture.astype(np.float32)
        noise = self._rng.standard_normal(light.shape, dtype=np.float32)
        spread = np.sqrt(scene.read_noise**2 + scene.shot_noise**2 / 255.0 * np.maximum(light, 0))
        grey = light + self._offset + spread.astype(np.float32) * noise
        return np.clip(np.rint(grey), 0, 255).astype(np.uint8)


def _tables(recording: _Recording, trial: Trial) -> dict[str, pd.DataFrame]:
    """Return the start pose and the truth."""
    scene, animal = recording.scene, recording.individual.animal
    poses, middle = recording.poses, recording.joints_px.shape[1] // 2
    points = points_px(poses, recording.joints_px[:, middle])
    seen = (points > -0.5).all(axis=-1) & (points < (scene.width - 0.5, scene.height - 0.5)).all(-1)
    seen &= ~under_body(animal, poses, points)
    whole = poses.frames[recording.whole]
    events = pd.DataFrame(columns=list(EVENTS_COLUMNS))
    if scene.motion == "run":
        events = events_truth(
            recording.motion,
            fps=FPS,
            frames=(int(whole[0]), int(whole[-1])),
            animal=trial.animal.id,
            trial=trial.name,
        )
    return {
        "start_pose.csv": start_truth(animal, poses.take(recording.whole)),
        "truth/pose.csv": pose_truth(animal, poses),
        "truth/tracks.csv": tracks_truth(
            point_names(animal), poses.frames, points, view=VIEW, visible=seen
        ),
        "truth/events.csv": events,
        "truth/phases.csv": phases_truth(events),
    }


def _describe(folder: Path, recording: _Recording, difficulty: str) -> Trial:
    """Describe the recording as a trial."""
    scene = recording.scene
    return Trial(
        kind="pose",
        name=f"spider-{difficulty}-{scene.motion}-{scene.seed:02d}",
        fps=FPS,
        animal=Animal(id=f"spider-{scene.seed:02d}", species=SPECIES),
        folder=folder,
        views=(
            View(
                name=VIEW,
                video=_VIDEO,
                background_frames=(0, int(recording.poses.frames[0])),
            ),
        ),
        calibration=Calibration(px_per_unit=scene.px_per_mm, unit="mm"),
        start_pose="start_pose.csv",
    )
