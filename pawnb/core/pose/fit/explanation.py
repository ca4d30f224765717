"""What the default method sees in a frame and makes of it, as pictures, while settings change."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.fit.layout import poses_of_vectors
from pawnb.core.pose.fit.learning.appearance import fit_appearance
from pawnb.core.pose.fit.observation import observe
from pawnb.core.pose.fit.prepare import check_on_animal, prepare_fitter
from pawnb.core.pose.fit.rendering.evidence import BackgroundPicture
from pawnb.core.pose.fit.rendering.paint_kernels import paint, picture_cost
from pawnb.core.pose.fit.sequence.first_frame import (
    first_darkness,
    fit_start,
    start_prior,
)
from pawnb.core.pose.fit.settings import PoseSettings
from pawnb.core.pose.fit.support import leg_supports
from pawnb.core.pose.poses import Poses
from pawnb.core.video.views import Frame


@dataclass(frozen=True, eq=False)
class FitView:
    """The parts of a fit as pictures of the crop ``box``.

    Parameters
    ----------
    box : tuple of int
        u0, v0, u1, v1 of the crop, half open, px of the view.
    darkness : ndarray, shape (H, W)
        How much the picture differs from the empty scene in its present light, 0 to 1: the
        evidence. Working pixels.
    painted : ndarray, shape (H, W)
        What the stick animal, as thick and as dark as was learnt from the frame, should show.
    unexplained : ndarray, shape (H, W)
        The absolute difference of the two.
    support : dict of str to float
        Of each leg, how dark its line is relative to what is expected, 0 to 1.
    cost : float
        What the fit makes as small as it can: the weighted errors of all pixels less those of an
        empty scene, so that a good pose has a large negative one.
    """

    box: tuple[int, int, int, int]
    darkness: FloatArray
    painted: FloatArray
    unexplained: FloatArray
    support: dict[str, float]
    cost: float


def explain_fit(
    frame: Frame,
    pose: Poses,
    *,
    animal: StickAnimal,
    background: BackgroundPicture,
    settings: PoseSettings | None = None,
) -> FitView:
    """Return what method ``pawnb`` sees in a frame, and what it would paint for a pose.

    Parameters
    ----------
    frame : Frame
        The frame.
    pose : Poses
        One frame's pose, roughly on the animal.
    animal : StickAnimal
        The animal.
    background : Background
        The empty scene.
    settings : PoseSettings, optional
        Settings tried.

    Returns
    -------
    FitView
        The pictures.

    Raises
    ------
    InputError
        If the pose lies outside the view.
    """
    settings = settings or PoseSettings()
    fitter, vector = prepare_fitter(
        frame, pose, animal=animal, background=background, settings=settings
    )
    fitter = fitter.with_initial_appearance(first_darkness(fitter, frame, vector))
    image_evidence, _, box = observe(fitter, frame, vector)
    prior = start_prior(fitter, vector)
    fitter = fit_appearance(fitter, [(vector, image_evidence)], prior=prior)
    canvas = fitter.canvas(image_evidence)
    paint(fitter.layout, vector, fitter.blur, image_evidence.box, *canvas)
    painted = canvas[0].copy()
    cost = picture_cost(
        canvas[0], canvas[1], image_evidence.seen, image_evidence.weight, settings.soft_error
    )
    support = np.fmin(*leg_supports(fitter, vector, image_evidence).T)
    factor = fitter.evidence.factor
    u0, v0, u1, v1 = (factor * edge for edge in box)
    return FitView(
        box=(u0, v0, u1, v1),
        darkness=image_evidence.seen,
        painted=painted,
        unexplained=np.abs(image_evidence.seen - painted),
        support=dict(zip(animal.leg_names, support.tolist(), strict=True)),
        cost=float(cost),
    )


def fit_to_picture(
    frame: Frame,
    pose: Poses,
    *,
    animal: StickAnimal,
    background: BackgroundPicture,
    settings: PoseSettings | None = None,
) -> tuple[Poses, float]:
    """Fit a rough pose to its frame, as tracking with method ``pawnb`` begins.

    Parameters
    ----------
    frame, pose, animal, background, settings
        As for :func:`explain_fit`.

    Returns
    -------
    pose : Poses
        The fitted pose of that frame.
    support : float
        How dark the body's place is relative to what is expected, 0 to 1.

    Raises
    ------
    InputError
        If the pose lies outside the view, or is not on the animal.
    """
    settings = settings or PoseSettings()
    fitter, vector = prepare_fitter(
        frame, pose, animal=animal, background=background, settings=settings
    )
    fitter, fitted, support = fit_start(fitter, frame, vector)
    check_on_animal(support, frame=frame.index)
    scale, factor = float(pose.scale[0]), fitter.evidence.factor
    found = poses_of_vectors(animal, fitted[None], frames=pose.frames, scale=scale, factor=factor)
    return found, support
