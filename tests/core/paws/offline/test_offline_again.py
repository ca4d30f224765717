"""What a correction needs to know of the run that it corrects."""

from __future__ import annotations

import numpy as np
import pytest

from pawnb.core.paws.offline.again import weighing_as_attributes, weighing_of
from pawnb.core.paws.offline.parameters import OfflineParameters
from pawnb.core.paws.offline.weighing import Weighing
from pawnb.io import native
from pawnb.schema import make_tracks


@pytest.mark.parametrize("found", [[0.91, 0.0, 0.25], [0.5], []])
def test_how_far_appearance_was_trusted_is_kept_in_the_file_of_tracks(tmp_path, found):
    tracks = make_tracks(range(3), ["FL"], fps=50.0, views=["side"])
    tracks.attrs.update(weighing_as_attributes(Weighing(1.0, np.array(found))))
    native.write_tracks(tracks, tmp_path / "tracks.nc")
    kept = weighing_of(native.read_tracks(tmp_path / "tracks.nc"))
    assert kept.trust == 1.0
    np.testing.assert_allclose(kept.found, found)


def test_tracks_that_say_nothing_are_taken_as_usual():
    kept = weighing_of(make_tracks(range(3), ["FL"], fps=50.0))
    assert kept.trust == OfflineParameters().appearance.trust
    assert len(kept.found) == 0
