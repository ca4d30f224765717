"""Reviewers keep what ipywidgets calls its own methods: repr of one ended in a TypeError."""

import pytest
from ipywidgets import Widget

from pawnb.widgets import PoseReviewer, TrackReviewer


@pytest.mark.parametrize("reviewer", [PoseReviewer, TrackReviewer])
def test_no_private_method_of_ipywidgets_is_covered(reviewer):
    assert reviewer._compare is Widget._compare
