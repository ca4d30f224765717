"""What looks wrong with a jointed animal's start frame, whoever asks: check or track."""

from __future__ import annotations

from pawnb.core.pose.silhouette import Silhouette

_SECOND_ANIMAL = 0.3
"""Things this large, as a share of the animal, may be a second one."""


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
    if outline.others > _SECOND_ANIMAL:
        doubts.append(
            f"frame {frame} shows something else of {100 * outline.others:.0f} % of the animal's "
            "size, perhaps a second animal; crop the view to one"
        )
    return doubts
