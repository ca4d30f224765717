"""A fitter made for an animal of known size in a frame, before its appearance is learnt."""

from __future__ import annotations

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.core.pixels.grey import grey
from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.fit.fitter import FrameFitter, make_fitter
from pawnb.core.pose.fit.layout import make_layout, pose_vectors
from pawnb.core.pose.fit.learning.anatomy import anatomy
from pawnb.core.pose.fit.parameters import FITTING
from pawnb.core.pose.fit.rendering.evidence import BackgroundPicture, make_evidence
from pawnb.core.pose.fit.settings import PoseSettings
from pawnb.core.pose.poses import Poses
from pawnb.core.video.views import Frame
from pawnb.errors import InputError


def prepare_fitter(
    frame: Frame,
    pose: Poses,
    *,
    animal: StickAnimal,
    background: BackgroundPicture,
    settings: PoseSettings,
) -> tuple[FrameFitter, FloatArray]:
    """Return a fitter for an animal, and its pose as a vector.

    Parameters
    ----------
    frame : Frame
        The frame that the pose belongs to.
    pose : Poses
        One frame; its scale is that of the fitter.
    animal : StickAnimal
        The animal.
    background : Background
        The empty scene.
    settings : PoseSettings
        Settings.

    Returns
    -------
    fitter : FrameFitter
        As dark as the species file's widths and the settings say.
    vector : ndarray, shape (n_parameters,)
        The pose, working pixels and radians.

    Raises
    ------
    InputError
        If the pose lies outside the view.
    """
    scale = float(pose.scale[0])
    factor = max(1, int(animal.span * scale / settings.working_span_px))
    light = _animal_light(frame, pose, animal, background)
    evidence = make_evidence(background, factor=factor, light=light, spread=settings.unexplained_sd)
    vector = pose_vectors(animal, pose, factor=factor)[0]
    prior = anatomy(animal, vector, foreshortening_sd=settings.foreshortening_sd)
    layout = make_layout(animal, px_per_unit=scale / factor)
    fitter = make_fitter(animal, layout, evidence=evidence, anatomy=prior, settings=settings)
    return fitter, vector


def check_on_animal(support: float, *, frame: int) -> None:
    """Refuse a start pose whose body's place is mostly empty.

    Parameters
    ----------
    support : float
        How dark the body's place is relative to what is expected, 0 to 1.
    frame : int
        Its frame.

    Raises
    ------
    InputError
        If it is less than half.
    """
    if support < FITTING.on_animal:
        share = 100 * max(support, 0.0)  # what is lighter than the background counts against it
        raise InputError(
            f"the start pose of frame {frame} is not on the animal: only {share:.0f} % of the "
            "body's place differs from the background; move it onto the animal."
        )


def _animal_light(
    frame: Frame, pose: Poses, animal: StickAnimal, background: BackgroundPicture
) -> float:
    """Return 0 for an animal darker than the background, else its grey value."""
    u, v = (round(float(x)) for x in pose.xy[0])
    half = max(3, round(FITTING.light_from * animal.body_length * float(pose.scale[0])))
    u0, v0 = max(0, u - half), max(0, v - half)
    u1, v1 = min(frame.width, u + half + 1), min(frame.height, v + half + 1)
    if u1 - u0 < 2 or v1 - v0 < 2:
        raise InputError(
            f"the start pose of frame {frame.index} lies at ({u}, {v}), outside the view of "
            f"{frame.width} x {frame.height} px; move it onto the animal."
        )
    image = grey(frame.crop(u0, v0, u1, v1), np.float64)
    empty = np.asarray(background.mean)[v0:v1, u0:u1]
    return (
        float(np.percentile(image, FITTING.light_percentile))
        if np.median(image - empty) > 0
        else 0.0
    )
