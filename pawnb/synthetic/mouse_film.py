"""The videos of a synthetic mouse: every view rendered and written, a thread each."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from pawnb.files import whole_file
from pawnb.synthetic.camera import PinholeCamera
from pawnb.synthetic.colour_video import H264VideoWriter, JpegVideoWriter
from pawnb.synthetic.grey_video import GreyVideoWriter
from pawnb.synthetic.lamps import cast_shadow
from pawnb.synthetic.mouse import Mouse
from pawnb.synthetic.render import Moment, ViewRenderer
from pawnb.synthetic.scene import LEGS, SceneSettings

Progress = Callable[[int, int], None]

_AHEAD = 3
"""Frames that may be under way at once: keeps memory flat."""
_FASTEST_MM_S = 1500.0
_STEP_MM = 1.0
_MOMENTS = (3, 15)
"""An open shutter is cut into moments between which the fastest paw goes so far; so many at least
and at most, an odd number, so that the middle one is that of the frame."""


def video_name(camera: PinholeCamera, scene: SceneSettings) -> str:
    """Return the file name of a view's video."""
    return f"{camera.name}.{'avi' if scene.crf is None else 'mp4'}"


def render_videos(
    folder: Path,
    mouse: Mouse,
    cameras: list[PinholeCamera],
    *,
    scene: SceneSettings,
    begin_s: float,
    frames: int,
    progress: Progress | None,
) -> np.ndarray:
    """Render all frames into a folder; return visible fractions (frames, views, legs).

    Times and visible fractions are those of the middle of the time the shutter is open.

    Parameters
    ----------
    folder : Path
        Where the videos are written.
    mouse : Mouse
        The animal.
    cameras : list of PinholeCamera
        One a view.
    scene : SceneSettings
        The scene.
    begin_s : float
        Time of the first frame, s.
    frames : int
        How many.
    progress : callable or None
        Told of every frame.

    Returns
    -------
    ndarray, shape (frames, views, legs)
        Which fraction of each paw is visible.
    """
    fractions = np.zeros((frames, len(cameras), len(LEGS)))
    with ExitStack() as stack:
        views = []
        for number, camera in enumerate(cameras):
            part = stack.enter_context(whole_file(folder / video_name(camera, scene)))
            writer = stack.enter_context(_open_writer(part, scene))
            worker = stack.enter_context(ThreadPoolExecutor(max_workers=1))
            views.append((ViewRenderer(camera, scene, number), writer, worker))
        under_way: deque[list[Future[dict[str, float]]]] = deque()
        done = 0

        def finish_oldest() -> None:
            nonlocal done
            for number, future in enumerate(under_way.popleft()):
                seen = future.result()
                fractions[done, number] = [seen[leg] for leg in LEGS]
            done += 1
            if progress is not None:
                progress(done, frames)

        for frame in range(frames):
            time_s = begin_s + frame / scene.fps
            moments = _moments(mouse, scene, time_s)

            def shoot(
                renderer: ViewRenderer,
                writer: Any,
                moments: list[Moment] = moments,
                frame: int = frame,
            ) -> dict[str, float]:
                (mesh, shadow, time_s), *others = moments
                picture, seen = renderer.render(
                    mesh, shadow, frame=frame, time_s=time_s, others=others
                )
                writer.write(_as_filmed(picture, scene))
                return seen

            under_way.append(
                [worker.submit(shoot, renderer, writer) for renderer, writer, worker in views]
            )
            if len(under_way) >= _AHEAD:
                finish_oldest()
        while under_way:
            finish_oldest()
    return fractions


def _moments(mouse: Mouse, scene: SceneSettings, time_s: float) -> list[Moment]:
    """Return the animal while the shutter is open, first as it is in the middle of that time."""
    open_s = scene.shutter / scene.fps
    count = 1
    if open_s:
        count = int(np.clip(open_s * _FASTEST_MM_S / _STEP_MM, *_MOMENTS)) // 2 * 2 + 1
    shifts = (np.arange(count) - count // 2) / count * open_s
    moments = []
    for shift in sorted(shifts, key=abs):
        mesh = mouse.mesh(time_s + float(shift))
        moments.append((mesh, cast_shadow(mesh, scene), time_s + float(shift)))
    return moments


def _as_filmed(picture: np.ndarray, scene: SceneSettings) -> np.ndarray:
    """Return a picture as the writer of the scene takes it."""
    if not scene.grey:
        return picture
    grey = cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY)
    return grey if scene.crf is None else np.repeat(grey[..., None], 3, axis=2)


def _open_writer(path: Path, scene: SceneSettings) -> Any:
    """Open a video for the pictures of a scene."""
    size, fps = (scene.width, scene.height), scene.fps
    if scene.crf is not None:
        return H264VideoWriter(path, size=size, fps=fps, crf=scene.crf)
    if scene.grey:
        return GreyVideoWriter(path, size=size, fps=fps)
    return JpegVideoWriter(path, size=size, fps=fps)
