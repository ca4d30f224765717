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
    leg_attachments_some, leg_attachments_whole : float
        Darkness of a leg, and share of the body's, from which on a pixel is partly covered, and
        share of the body's from which on it is wholly. Set by hand.
    """

    blocks_across: int = 9
    evidence_uneven: float = 0.02
    evidence_black: float = 0.9
    leg_attachments_some: float = 0.15
    leg_attachments_whole: float = 0.97


RENDERING = in_force("rendering", RenderingParameters())
"""The values in force; see :func:`pawnb.core.parameters.in_force`."""
