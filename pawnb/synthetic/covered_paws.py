"""Fur over the paws of the synthetic mouse when they lift off, so that they turn dark."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

import numpy as np

from pawnb.synthetic.scene import SceneSettings
from pawnb.synthetic.surfaces import Mesh

# of a leg: 0 to 1 in stance, 1 to 2 in swing
_PHASES = (0.0, 0.78, 0.95, 1.25, 1.45, 2.0)
_COVERED = (0.0, 0.0, 1.0, 1.0, 0.0, 0.0)


def cover_paws(
    mesh: Mesh,
    limbs: Mapping[str, slice],
    phases: Mapping[str, float],
    *,
    settings: SceneSettings,
) -> Mesh:
    """Return a mesh whose paws have the colour of the fur while fur lies over them.

    The fur is thin: a paw keeps its shape, and counts as seen.

    Parameters
    ----------
    mesh : Mesh
        The animal.
    limbs : mapping of str to slice
        Vertices of each leg's limb.
    phases : mapping of str to float
        0 to 1 through a leg's stance, from touch-down, and 1 to 2 through its swing.
    settings : SceneSettings
        How much of the colour is that of the fur.

    Returns
    -------
    Mesh
        The same shape with other colours.
    """
    colour, fur = mesh.colour.copy(), mesh.fur.copy()
    for leg, vertices in limbs.items():
        share = settings.covered_paws * np.interp(phases[leg], _PHASES, _COVERED)
        over = np.minimum(colour[vertices], settings.fur_rgb)  # what is darker stays
        if np.mean(settings.fur_rgb) > np.mean(settings.paw_rgb):
            over = np.maximum(colour[vertices], settings.fur_rgb)
        colour[vertices] += share * (over - colour[vertices])
        fur[vertices] = np.maximum(fur[vertices], 0.6 * share)
    return dataclasses.replace(mesh, colour=colour, fur=fur)
