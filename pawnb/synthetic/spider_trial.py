"""A synthetic recording of a spider on disk: video, start pose and the truth."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

from pawnb.arrays import BoolArray, FloatArray
from pawnb.errors import InputError
from pawnb.files import whole_file
from pawnb.io.tables import write_text
from pawnb.schema import EVENTS_COLUMNS
from pawnb.synthetic.spider_film import Progress, render_video
from pawnb.synthetic.spider_recording import SpiderRecording, record_spider
from pawnb.synthetic.spider_scene import FPS, SPECIES, draw_individual, spider_scene
from pawnb.synthetic.spider_side import dlt_coefs, points3d_truth, split_row, to_side
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

TOP, SIDE = "top", "side"
_VIDEO = "spider.avi"


def render_spider_trial(
    folder: str | Path,
    *,
    frames: int = 120,
    scale: float = 0.5,
    seed: int = 0,
    difficulty: str = "normal",
    motion: str = "run",
    views: int = 1,
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
    views : {1, 2}
        2 adds the view from the side, through a mirror at 45 degrees: another crop of the
        same video.
    progress : callable, optional
        Called with (frames done, frames in all).

    Returns
    -------
    Path
        ``trial.toml``, the last file that is written.

    Raises
    ------
    InputError
        For an unknown difficulty or motion, a scale, seed or number of views that makes no
        sense, or too few frames to hold the whole animal.

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
    if views not in (1, 2):
        raise InputError(f"views is {views}; expected 1 or 2.")
    folder = Path(folder)
    individual = draw_individual(scene)
    recording = record_spider(scene, individual, frames)
    (folder / "truth").mkdir(parents=True, exist_ok=True)
    (folder / "trial.toml").unlink(missing_ok=True)
    with whole_file(folder / _VIDEO) as part:
        render_video(part, recording, views=views, progress=progress)
    trial = _describe(folder, recording, (difficulty, views))
    for name, table in _tables(recording, trial).items():
        write_text(table.to_csv(index=False, lineterminator="\n"), folder / name)
    if views == 2:
        coefs = pd.DataFrame(dlt_coefs(scene))
        text = coefs.to_csv(header=False, index=False, lineterminator="\n")
        write_text(text, folder / "DLTcoefs.csv")
    return save_trial(trial, folder / "trial.toml")


def _tables(recording: SpiderRecording, trial: Trial) -> dict[str, pd.DataFrame]:
    """Return the start pose and the truth."""
    scene, animal = recording.scene, recording.individual.animal
    poses, whole = recording.poses, recording.poses.frames[recording.whole]
    names = point_names(animal)
    points = points_px(poses.xy, recording.middle(recording.joints_px))
    size = (scene.width, split_row(scene) if len(trial.views) == 2 else scene.height)
    seen = _within(points, size) & ~under_body(animal, poses, points)
    tracks = tracks_truth(names, poses.frames, points, view=TOP, visible=seen)
    tables = {}
    if len(trial.views) == 2:
        heights = points_px(
            recording.middle(recording.body_heights_mm)[:, None],
            recording.middle(recording.heights_mm)[..., None],
        )[..., 0]
        side = to_side(scene, points[..., 0], heights) - (0, split_row(scene))
        seen = _within(side, (scene.width, scene.height - split_row(scene)))
        more = tracks_truth(names, poses.frames, side, view=SIDE, visible=seen)
        tracks = pd.concat([tracks, more]).sort_values("frame", kind="stable")
        tables["truth/points3d.csv"] = points3d_truth(
            recording, names, points=points, heights=heights
        )
    events = pd.DataFrame(columns=list(EVENTS_COLUMNS))
    if scene.motion == "run":
        events = events_truth(
            recording.motion,
            fps=FPS,
            frames=(int(whole[0]), int(whole[-1])),
            animal=trial.animal.id,
            trial=trial.name,
        )
    return tables | {
        "start_pose.csv": start_truth(animal, poses.take(recording.whole)),
        "truth/pose.csv": pose_truth(animal, poses),
        "truth/tracks.csv": tracks,
        "truth/events.csv": events,
        "truth/phases.csv": phases_truth(events),
    }


def _within(points: FloatArray, size: tuple[int, int]) -> BoolArray:
    """Return which points (..., 2) lie in a picture of that width and height."""
    inside = (points > -0.5).all(axis=-1) & (points < np.array(size) - 0.5).all(axis=-1)
    return np.asarray(inside)


def _describe(folder: Path, recording: SpiderRecording, what: tuple[str, int]) -> Trial:
    """Describe the recording as a trial."""
    scene, (difficulty, views) = recording.scene, what
    empty = (0, int(recording.poses.frames[0]))
    row = split_row(scene)
    crops: dict[str, tuple[int, int, int, int] | None] = {TOP: None}
    calibration = Calibration(px_per_unit=scene.px_per_mm, unit="mm")
    if views == 2:
        crops = {TOP: (0, 0, scene.width, row), SIDE: (0, row, scene.width, scene.height)}
        calibration = Calibration(dlt="DLTcoefs.csv", unit="mm")
    return Trial(
        kind="pose",
        name=f"spider-{difficulty}-{scene.motion}-{scene.seed:02d}",
        fps=FPS,
        animal=Animal(id=f"spider-{scene.seed:02d}", species=SPECIES),
        folder=folder,
        views=tuple(
            View(name=name, video=_VIDEO, crop=crop, background_frames=empty)
            for name, crop in crops.items()
        ),
        calibration=calibration,
        start_pose="start_pose.csv",
    )
