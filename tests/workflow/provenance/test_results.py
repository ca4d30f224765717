"""What is said of a folder of results that are not of one another."""

from __future__ import annotations

import pytest

from pawnb.errors import InputWarning
from pawnb.schema import ORIGIN_CODE, add_provenance, make_tracks
from pawnb.workflow.provenance.manifest import writing_results
from pawnb.workflow.provenance.record import file_checksum
from pawnb.workflow.provenance.results import write_track_results


def tracks_at(u):
    """Return tracks of a point that stands still there."""
    tracks = make_tracks(range(5), ["FR"], fps=100.0, views=["side"], space=("x", "y"))
    tracks["image_position"][:] = u
    tracks["image_origin"][:] = ORIGIN_CODE["measured"]
    return add_provenance(tracks, step="track", method="pawnb", settings={}, inputs={})


def test_gait_of_other_tracks_is_said_where_a_trial_is_tracked_again(tmp_path):
    """Tables of gait stayed beside new tracks, and nothing said that they were of the old ones."""
    write_track_results(tracks_at(1.0), tmp_path, warn=True)
    read = {f"{tmp_path.name}/tracks.nc": file_checksum(tmp_path / "tracks.nc")}
    step = {"step": "gait", "inputs": read}
    with writing_results(tmp_path, run="gait", steps=[step]) as staging:
        (staging / "strides.csv").write_text("leg\n")
    write_track_results(tracks_at(1.0), tmp_path, warn=True)  # the same: nothing is said
    with pytest.warns(InputWarning, match=r"tracks\.nc has changed since the gait was analysed;"):
        write_track_results(tracks_at(2.0), tmp_path, warn=True)
