"""Parameters of the stage ``rendering``, each with unit and evidence."""

from __future__ import annotations

from dataclasses import dataclass

from pawnb.core.parameters import in_force


@dataclass(frozen=True)
class RenderingParameters:
    """The animal as it is painted, and the evidence of the picture.

    Parameters
    ----------
    blocks_across : int
        Blocks along the crop in which the light is estimated. Set by hand.
    evidence_uneven, evidence_black : float
        Darkness below which a wide thing is unevenness of the background; and at most of one. Set
        by hand.
    black_level : float
        Grey value up to which the background is black: it tells nothing of the light. Set by hand.
    light_spread : float
        Standard deviation, in blocks, with which the light is smoothed. Set by hand.
    darkness_limits : tuple of float
        Least and most darkness of a pixel: 0 is the background, 1 black. Set by hand.
    least_contrast : float
        Least contrast of an animal that is lighter than the background, grey values. Set by hand.
    leg_attachments_some, leg_attachments_whole : float
        Darkness of a leg, and share of the body's, from which on a pixel is partly covered, and
        share of the body's from which on it is wholly. Set by hand.
    least_block_px : int
        Side of the blocks for each of which the light is estimated, working px, at least. Set by
        hand.
    """

    blocks_across: int = 9
    evidence_uneven: float = 0.02
    evidence_black: float = 0.9
    black_level: float = 4.0
    light_spread: float = 0.8
    darkness_limits: tuple[float, float] = (-0.5, 1.5)
    least_contrast: float = 16.0
    leg_attachments_some: float = 0.15
    leg_attachments_whole: float = 0.97
    least_block_px: int = 12


RENDERING = in_force("rendering", RenderingParameters())
"""The values in force; see :func:`pawnb.core.parameters.in_force`."""
