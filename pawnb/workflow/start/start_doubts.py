"""What looks wrong with a jointed animal's start frame, whoever asks: check or track."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.background import Background
from pawnb.core.pose.doubts.travel import TRAVEL_FRAMES, is_backwards
from pawnb.core.pose.poses import Poses, joint_positions
from pawnb.core.pose.start_proposal.silhouette import Silhouette, find_silhouette
from pawnb.core.video import ViewReader
from pawnb.core.video.doubts.exchanged_films import tell_other_films
from pawnb.io.lengths import MM_PER_UNIT
from pawnb.io.pose import films_of_poses
from pawnb.trial import Trial

SECOND_ANIMAL = 0.3
"""Things this large, as a share of the animal, may be a second one."""

_OTHER_SIZE = 1.5
"""An animal is so many times as large or small as its species file says, or it is spoken of."""

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


def tell_size(animal: StickAnimal, pose: Poses, *, trial: Trial) -> list[str]:
    """Say where the animal is far larger or smaller than its species file has it.

    Parameters
    ----------
    animal : StickAnimal
        The animal.
    pose : Poses
        One frame.
    trial : Trial
        The trial, whose calibration is compared.

    Returns
    -------
    list of str
        A sentence, or nothing.
    """
    known = trial.calibration
    if known is None or known.px_per_unit is None:
        return []
    if not {known.unit, animal.unit} <= MM_PER_UNIT.keys():
        return []
    length = animal.body_length * float(pose.scale[0]) / known.px_per_unit
    times = length * MM_PER_UNIT[known.unit] / (animal.body_length * MM_PER_UNIT[animal.unit])
    if 1 / _OTHER_SIZE < times < _OTHER_SIZE:
        return []
    return [
        f"start pose of frame {pose.frames[0]}: by px_per_unit the body is {length:.3g} "
        f"{known.unit} long, {times:.2g} times as large as its species file says; look at "
        "px_per_unit and the species: lengths and speeds are as wrong as the scale is"
    ]


def tell_backwards(
    animal: StickAnimal, pose: Poses, *, reader: ViewReader, background: Background
) -> list[str]:
    """Say where the animal goes to the rear of its start pose.

    Parameters
    ----------
    animal : StickAnimal
        The animal.
    pose : Poses
        One frame.
    reader : ViewReader
        The view.
    background : Background
        Its empty scene.

    Returns
    -------
    list of str
        A sentence, or nothing; nothing either where it goes nowhere or may not be alone.
    """
    frame, heading = int(pose.frames[0]), float(pose.heading_deg[0])
    body_px = animal.body_length * float(pose.scale[0])
    for apart in TRAVEL_FRAMES:
        places = {
            at: place
            for at in (max(frame - apart, 0), frame, min(frame + apart, reader.n_frames - 1))
            if (place := _body_place(reader, background, at)) is not None
        }
        if len(places) < 2:
            return []
        way = places[max(places)] - places[min(places)]
        told = is_backwards(way, heading, body_px=body_px)
        if told is False:
            return []
        if told:
            return [
                f"start pose of frame {frame}: the animal goes backwards from frame {min(places)} "
                f"to {max(places)}; if it does not, its heading is the wrong way round, and every "
                "leg is taken for another: turn the stick animal about, and pose its legs anew"
            ]
    return []


def _body_place(reader: ViewReader, background: Background, frame: int) -> FloatArray | None:
    """Return where the body is in a frame, px; None where the whole animal is not seen, alone."""
    outline = find_silhouette(reader.frame(frame).image(), background)
    if outline is None or outline.at_edge or outline.others > SECOND_ANIMAL:
        return None
    v, u = np.nonzero(outline.core)
    return outline.to_view(np.array([u.mean(), v.mean()]))
