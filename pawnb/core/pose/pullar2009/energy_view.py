"""The terms of the energy as pictures, for a live view while settings change.

Pullar 2009, §3.4.3: the image with the shape model and the shape prior were shown during tracking,
"to allow the user to observe the effects of altering different parameter values".
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pawnb.arrays import BoolArray, ByteArray, Float32Array, FloatArray
from pawnb.core.pixels.grey import grey
from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.contrast import edge_fall, squared_gradient
from pawnb.core.pose.poses import Poses
from pawnb.core.pose.pullar2009.energy import Box, Pullar2009Energy
from pawnb.core.pose.pullar2009.likelihood import EmptyScene, background_cost
from pawnb.core.pose.pullar2009.mincut import grid_energy
from pawnb.core.pose.pullar2009.settings import EnergyParameters, Pullar2009Settings
from pawnb.core.pose.pullar2009.sticks import distance_map, pose_vector

_MOST_EXPONENT = 500.0
"""Guard: exponents beyond this would overflow."""


@dataclass(frozen=True, eq=False)
class EnergyView:
    """The terms of the energy as pictures of the crop ``box``: what a person looks at.

    Parameters
    ----------
    box : tuple of int
        u0, v0, u1, v1 of the crop, half open, px of the view.
    background_cost : ndarray, shape (H, W)
        Cost of calling a pixel background (Fig. 3.5a).
    subject_cost : ndarray, shape (H, W)
        Cost of calling a pixel subject, from its grey value.
    contrast : ndarray, shape (H, W)
        Cost of a border between labels at a pixel: Ising and contrast term, low at edges.
    shape_prior : ndarray, shape (H, W)
        Probability of the label subject, 0 to 1 (Eq. 3.15; Fig. 3.9a).
    segmentation : ndarray of bool, shape (H, W)
        The labelling of least energy (Fig. 3.9b).
    terms : dict of str to float
        ``likelihood``, ``shape prior``, ``Ising``, ``contrast`` and ``joint ranges``: their sum
        over the crop is ``energy``.
    energy : float
        The energy.
    parameters : EnergyParameters
        What was set or estimated.
    """

    box: Box
    background_cost: Float32Array
    subject_cost: Float32Array
    contrast: Float32Array
    shape_prior: FloatArray
    segmentation: BoolArray
    terms: dict[str, float]
    energy: float
    parameters: EnergyParameters


def explain_energy(
    picture: ByteArray,
    pose: Poses,
    *,
    animal: StickAnimal,
    background: EmptyScene,
    settings: Pullar2009Settings | None = None,
) -> EnergyView:
    """Return the terms of the energy of one frame and pose as pictures, for a live view.

    Parameters
    ----------
    picture : ndarray, shape (H, W) or (H, W, 3)
        The frame; parameters that are not set are estimated from it.
    pose : Poses
        One pose (its frame number does not matter).
    animal : StickAnimal
        The animal.
    background : Background
        The empty scene.
    settings : Pullar2009Settings, optional
        Settings.

    Returns
    -------
    EnergyView
        The terms on a crop about the animal.

    Raises
    ------
    InputError
        If nothing in the picture stands out of the background.
    """
    energy = Pullar2009Energy(
        animal, pose, picture=picture, background=background,
        settings=settings or Pullar2009Settings(),
    )  # fmt: skip
    vector, p = pose_vector(pose), energy.parameters
    frame = energy.frame(picture, vector, slack_px=0.0)
    cut = energy.cut(frame, vector)
    u0, v0, u1, v1 = frame.box
    crop = grey(picture)[v0:v1, u0:u1]
    whole = background_cost(grey(picture), background, sd_floor_grey=energy.settings.sd_floor_grey)
    back = whole[v0:v1, u0:u1]
    sticks = energy.sticks
    away = distance_map(
        (u0, v0), crop.shape, vector[2], sticks.points(vector), sticks.n_links,
        sticks.parts(vector), float(sum(crop.shape)),
    )  # fmt: skip
    x = np.clip(
        p.steepness * (away.astype(float) - p.thickness_px), -_MOST_EXPONENT, _MOST_EXPONENT
    )
    shape = np.where(cut.labels, np.logaddexp(0, x), np.logaddexp(0, -x)).sum()
    different = float(
        (cut.labels[:, 1:] != cut.labels[:, :-1]).sum() + (cut.labels[1:] != cut.labels[:-1]).sum()
    )
    _, pairs = grid_energy(cut.labels, frame.own, right=frame.right, down=frame.down)
    terms = {
        "likelihood": float((back + frame.own * cut.labels).sum(dtype=float)),
        "shape prior": float(shape),
        "Ising": p.ising * different,
        "contrast": pairs - p.ising * different,
        "joint ranges": energy.limits(vector),
    }
    return EnergyView(
        box=frame.box,
        background_cost=back,
        subject_cost=frame.own + back,
        contrast=p.ising + p.contrast * edge_fall(squared_gradient(crop), p.edge_grey),
        shape_prior=1 / (1 + np.exp(x)),
        segmentation=cut.labels,
        terms=terms,
        energy=cut.energy,
        parameters=p,
    )
