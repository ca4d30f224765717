"""What looks wrong with a jointed animal's start frame, whoever asks: check or track."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.poses import Poses, joint_positions
from pawnb.core.pose.start_proposal.silhouette import Silhouette
from pawnb.core.video.doubts.exchanged_films import tell_other_films
from pawnb.io.pose import films_of_poses

SECOND_ANIMAL = 0.3
"""Things this large, as a share of the animal, may be a second one."""


_SPARE_SPAN = 0.1
"""How far beyond the picture a leg may seem to reach, of the leg span, where nothing says how
long it looks: legs that are raised are shorter."""


def legs_outside(animal: StickAnimal, pose: Poses, *, size: tuple[int, int]) -> list[str]:
    """Return the legs of a start pose that reach out of a picture.

    Parameters
    ----------
    animal : StickAnimal
        The animal.
    pose : Poses
        One frame.
    size : tuple of int
        Width and height of the picture, px.

    Returns
    -------
    list of str
        Their names.
    """
    places = joint_positions(animal, pose)[0]
    flat = np.allclose(pose.lengths_px, pose.scale[:, None] * animal.lengths)
    spare = _SPARE_SPAN * animal.span * float(pose.scale[0]) if flat else 0.5
    inside = ((places > -spare) & (places < np.array(size) - 1 + spare)).all(axis=-1)
    off = (~inside & np.isfinite(places[..., 0])).any(axis=1)
    return [name for name, out in zip(animal.leg_names, off, strict=True) if out]


def say_outside(names: list[str], frame: int) -> str:
    """Return the sentence about legs that reach out of the picture."""
    return (
        f"start pose of frame {frame}: {', '.join(names)} reach off the picture; start in a "
        "frame with the whole animal in view"
    )


def start_doubts(outline: Silhouette, frame: int) -> list[str]:
    """Return what a person should know of a start frame, in sentences.

    Parameters
    ----------
    outline : Silhouette
        What differs from the empty scene in it.
    frame : int
        Its number.

    Returns
    -------
    list of str
        That the animal touches the edge of the picture, or may not be alone in it.
    """
    doubts = []
    if outline.at_edge:
        doubts.append(
            f"the animal touches the edge of the picture in frame {frame} of the start pose; start "
            "in a frame with the whole animal in view"
        )
    if outline.others > SECOND_ANIMAL:
        doubts.append(
            f"frame {frame} shows something else of {100 * outline.others:.0f} % of the animal's "
            "size, perhaps a second animal; crop the view to one"
        )
    return doubts


def tell_other_film(path: str | Path, *, view: str, film: str) -> list[str]:
    """Say where the poses to start from were made in another film than their view shows now.

    Parameters
    ----------
    path : str or Path
        ``start_pose.csv``.
    view : str
        The view that they are in.
    film : str
        The code of its film (:func:`pawnb.core.video.doubts.exchanged_films.film_code`).

    Returns
    -------
    list of str
        A sentence, or nothing.
    """
    posed = set(films_of_poses(path).values())
    return tell_other_films({view: film}, {view: posed}, start="poses") if posed else []
