"""What clicks say about a recording: from which frame."""

import numpy as np

from pawnb.core.paws.layout import Placement
from pawnb.core.paws.offline.scene.clicks import frame_with_most_annotations


def placed(*pairs):
    """Placements of (view, point) pairs."""
    return [Placement(view, point, np.zeros(2)) for view, point in pairs]


def test_sizes_are_told_by_the_frame_in_which_most_points_were_clicked():
    clicks = placed((0, 0), (1, 0), (0, 1))
    # corrected before, one paw in three views; and, later, both in one view each
    assert (
        frame_with_most_annotations(
            {40: clicks, 10: placed((0, 0), (1, 0), (2, 0)), 90: placed((0, 0), (0, 1))}
        )
        == 40
    )


def test_of_frames_clicked_alike_the_first_counts():
    assert (
        frame_with_most_annotations(
            {7: placed((0, 0), (0, 1)), 3: placed((1, 0), (1, 1)), 9: placed((0, 1))}
        )
        == 3
    )
