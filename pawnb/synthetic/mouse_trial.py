"""A synthetic recording on disk: four videos, calibration, start clicks and the truth."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pawnb.errors import InputError
from pawnb.io.tables import write_text
from pawnb.synthetic.camera import PinholeCamera, make_cameras
from pawnb.synthetic.gait_model import Gait, plan_gait
from pawnb.synthetic.mouse import Mouse
from pawnb.synthetic.mouse_film import Progress, render_videos, video_name
from pawnb.synthetic.render import cover, paw_fractions
from pawnb.synthetic.scene import LEGS, SceneSettings, scene_settings
from pawnb.synthetic.truth import (
    events_truth,
    landmarks_truth,
    paw_positions,
    points3d_truth,
    start_clicks,
    tracks_truth,
)
from pawnb.synthetic.variants import vary
from pawnb.trial import Animal, Calibration, Trial, View, save_trial

_START_SCALE = 0.2
_START_CANDIDATES = 24


def render_mouse_trial(
    folder: str | Path,
    *,
    frames: int = 120,
    scale: float = 0.5,
    seed: int = 0,
    difficulty: str = "normal",
    settings: Mapping[str, Any] | None = None,
    variants: Sequence[str] = (),
    progress: Progress | None = None,
) -> Path:
    """Render a mouse on a treadmill, seen by up to four cameras, with its exact truth.

    Parameters
    ----------
    folder : str or Path
        Where to write; made if it is not there.
    frames : int
        Number of frames.
    scale : float
        1 is 2048 x 700 px a view.
    seed : int
        Another seed is another animal, gait, rig and background.
    difficulty : {"easy", "normal", "hard"}
        How regular the gait, how clear the colours, how quiet the sensor.
    settings : mapping, optional
        Further fields of :class:`pawnb.synthetic.SceneSettings`; they go before
        ``scale``, ``seed`` and the preset.
    variants : sequence of str, optional
        What makes the recording worse, or other: names of
        :data:`pawnb.synthetic.variants.VARIANTS`, which go before all of these. The animal, its
        gait and the truth of it stay.
    progress : callable, optional
        Called with (frames done, frames in all).

    Returns
    -------
    Path
        ``trial.toml``, the last file that is written.

    Raises
    ------
    InputError
        For a setting that is unknown or makes no sense, or fewer than 2 frames.

    Notes
    -----
    The tracked point of a paw is the centre of its digits, that is of the distal third of
    the paw, midway between their base and their tips and at half their thickness. While the
    paw stands it lies 1.2 mm above the belt and moves exactly with it.

    Files: ``cam1.avi`` ... (MJPEG; H.264 is ``cam1.mp4``), ``DLTcoefs.csv``, ``start.csv``,
    ``trial.toml``, and in ``truth/`` the tables ``tracks.csv`` (every paw in every view;
    ``visible_fraction`` is the share of the paw's picture that nothing hides, ``visible`` is 1
    above 0.3), ``points3d.csv``, ``landmarks3d.csv`` (nose, ears, base and tip of the tail: frame,
    point, x, y, z) and ``events.csv``. A view on the animal's right tracks FR and HR, one on its
    left FL and HL, one from below all four. Recordings begin where all paws are well seen, as a
    person would choose. The same arguments give the same bytes with the same versions of the
    libraries.
    """
    scene = scene_settings(
        difficulty, changes={"scale": scale, "seed": seed, **(dict(settings or {}))}
    )
    if frames < 2:
        raise InputError(f"frames is {frames}; expected 2 or more.")
    scene = vary(scene, variants)
    folder = Path(folder)
    (folder / "truth").mkdir(parents=True, exist_ok=True)
    (folder / "trial.toml").unlink(missing_ok=True)
    gait = plan_gait(scene, frames / scene.fps)
    cameras = make_cameras(scene)
    mouse = Mouse(scene, gait)
    begin_s = find_start(mouse, gait, scene)
    fractions = render_videos(
        folder, mouse, cameras, scene=scene, begin_s=begin_s, frames=frames, progress=progress
    )
    name = "-".join(["synthetic", difficulty, f"{scene.seed:02d}", *variants])
    trial = _describe(folder, scene, cameras, name)
    times_s = np.arange(frames) / scene.fps
    positions = paw_positions(gait, scene, begin_s + times_s)
    tracks = tracks_truth(positions, fractions, cameras)
    events = events_truth(
        gait, scene, begin_s=begin_s, frames=frames, animal=trial.animal.id, trial=trial.name
    )
    clicks = start_clicks(tracks, {view.name: view.points for view in trial.views})
    for name, table in (
        ("truth/tracks.csv", tracks),
        ("truth/points3d.csv", points3d_truth(positions)),
        ("truth/landmarks3d.csv", landmarks_truth(mouse, begin_s + times_s)),
        ("truth/events.csv", events),
        ("start.csv", clicks),
    ):
        write_text(table.to_csv(index=False, lineterminator="\n"), folder / name)
    coefs = pd.DataFrame(np.column_stack([camera.coefs for camera in cameras]))
    text = coefs.to_csv(header=False, index=False, lineterminator="\n")
    write_text(text, folder / "DLTcoefs.csv")
    return save_trial(trial, folder / "trial.toml")


def tracked_legs(camera: PinholeCamera, settings: SceneSettings) -> tuple[str, ...]:
    """Return the legs on the side of the animal that a camera sees; from below all of them."""
    if camera.side == 0:
        return LEGS
    return ("FR", "HR") if camera.side * settings.direction < 0 else ("FL", "HL")


def find_start(mouse: Mouse, gait: Gait, settings: SceneSettings) -> float:
    """Return the time, s, at which to begin: when the paws are best seen where they are tracked.

    Looks through one stride at a small scale and takes the moment whose worst-seen paw is
    seen best.

    Parameters
    ----------
    mouse : Mouse
        The animal.
    gait : Gait
        How it runs.
    settings : SceneSettings
        The scene.

    Returns
    -------
    float
        The time, s.
    """
    small = dataclasses.replace(settings, scale=_START_SCALE)
    cameras = make_cameras(small)
    best_s, best = gait.earliest_s, -1.0
    for step in range(_START_CANDIDATES):
        time_s = gait.earliest_s + gait.mean_period_s * step / _START_CANDIDATES
        mesh = mouse.mesh(time_s)
        worst = 1.0
        for camera in cameras:
            seen = paw_fractions(mesh, cover(mesh, camera, small))
            worst = min([worst, *(seen[leg] for leg in tracked_legs(camera, settings))])
        if worst > best + 1e-9:
            best_s, best = time_s, worst
    return best_s


def _describe(folder: Path, scene: SceneSettings, cameras: list[PinholeCamera], name: str) -> Trial:
    """Describe the recording as a trial."""
    return Trial(
        kind="paws",
        name=name,
        fps=scene.fps,
        animal=Animal(id=f"synthetic-{scene.seed:02d}", species="mouse"),
        folder=folder,
        belt_speed=scene.belt_speed_mm_s,
        views=tuple(
            View(name=c.name, video=video_name(c, scene), points=tracked_legs(c, scene))
            for c in cameras
        ),
        calibration=Calibration(
            dlt="DLTcoefs.csv", unit="mm", forward=(float(scene.direction), 0.0, 0.0)
        ),
        start_points="start.csv",
    )
