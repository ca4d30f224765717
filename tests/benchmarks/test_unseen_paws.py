"""Taking detections away leaves the clicked frames, and takes of a paw its own only."""

from types import SimpleNamespace

import numpy as np
import pytest

from pawnb.core.paws.offline.detection.colour.detections import ColourDetections


@pytest.fixture
def recording(tmp_path):
    """Two paws 100 px apart that stand for ten frames in one view, and their detections."""
    from unseen_paws import Recording

    (tmp_path / "truth").mkdir()
    (tmp_path / "truth" / "events.csv").write_text(
        "leg,event,frame\nFR,TD,1.0\nFR,LO,4.2\nHR,TD,4.0\n"
    )
    places = np.array([[100.0, 50.0], [200.0, 50.0]])
    asked = SimpleNamespace(layout=SimpleNamespace(points=["FR", "HR"]), clicks={0: ()})
    scene = SimpleNamespace(paw_width_px=np.array([10.0]))
    return Recording(
        trial=SimpleNamespace(folder=tmp_path),
        asked={"asked": asked, "scene": scene},
        seen=[[ColourDetections(np.column_stack([places, np.zeros((2, 6))]))] for _ in range(10)],
        uv=np.tile(places, (10, 1, 1, 1)),
        x=np.zeros((10, 2, 3)),
    )


def test_a_share_is_left_out_but_not_of_clicked_frames(recording):
    from unseen_paws import thinned

    counts = [len(here[0]) for here in thinned(recording, 1, share=0.5)]
    assert counts[0] == 2
    assert 0 < sum(counts[1:]) < 18
    assert [len(here[0]) for here in thinned(recording, 1, share=1.0)][1:] == [0] * 9
    assert sum(len(here[0]) for here in recording.seen) == 20


def test_a_paw_is_not_seen_from_before_it_lifts_off(recording):
    from unseen_paws import unseen_at_lift_off

    seen = unseen_at_lift_off(recording, 0, frames=3)
    left = [here[0].uv[:, 0].tolist() for here in seen]
    assert left[3:6] == [[200.0]] * 3
    assert left[:3] + left[6:] == [[100.0, 200.0]] * 7
