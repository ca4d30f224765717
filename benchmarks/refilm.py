"""Film a rendered scene in another way: its colour film again in grey, or as H.264.

Rendering takes longer than all else, and the animal is the same in every film.
"""

from __future__ import annotations

import re
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from pawnb.core.video import open_views
from pawnb.synthetic.colour_video import H264VideoWriter
from pawnb.synthetic.grey_video import GreyVideoWriter
from pawnb.trial import load_trial

GREY, H264 = "grey", re.compile(r"h264-crf(\d{1,2})")


def can_refilm(variants: Sequence[str]) -> bool:
    """Tell whether films differ from the colour one only by how pictures are kept."""
    return all(name == GREY or H264.fullmatch(name) for name in variants)


def refilm(scene: Path, folder: Path, variants: Sequence[str]) -> Path:
    """Write a scene's views again.

    Parameters
    ----------
    scene : Path
        ``trial.toml`` of a scene in colour.
    folder : Path
        Where to write the same scene.
    variants : sequence of str
        ``grey``, ``h264-crfNN``, or both.

    Returns
    -------
    Path
        ``trial.toml``, the last file that is written.
    """
    trial = load_trial(scene)
    kept = shutil.ignore_patterns("*.avi", "*.toml")
    shutil.copytree(scene.parent, folder, ignore=kept, dirs_exist_ok=True)
    crf = [int(name[1]) for name in map(H264.fullmatch, variants) if name]
    name = "-".join([trial.name, *variants])
    text = scene.read_text().replace(f'name = "{trial.name}"', f'name = "{name}"')
    with open_views(trial) as views:
        for view in trial.views:
            old, new = view.video, f"{view.name}.{'mp4' if crf else 'avi'}"
            reader = views.readers[view.name]
            options: dict[str, Any] = {"size": (reader.width, reader.height), "fps": trial.fps}
            path = folder / new
            with (
                H264VideoWriter(path, crf=crf[0], **options)
                if crf
                else GreyVideoWriter(path, **options)
            ) as writer:
                for frame in range(views.n_frames):
                    picture = reader.read(frame)
                    if GREY in variants:
                        picture = cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY)
                        if crf:
                            picture = np.repeat(picture[..., None], 3, axis=2)
                    writer.write(picture)
            text = text.replace(f'video = "{old}"', f'video = "{new}"')
    (folder / "trial.toml").write_text(text)
    return folder / "trial.toml"
