"""Real clips that are filmed again: marks, clicks and cameras stay on the same things."""

import cv2
import numpy as np
import pandas as pd
import pytest
import tomli_w


@pytest.fixture
def clip(tmp_path):
    """A clip of a bright square of 8 px that stands at (24..31, 12..19) in all of six frames."""
    from real_clip_marks import Clip

    from pawnb.synthetic.colour_video import JpegVideoWriter

    folder = tmp_path / "square"
    folder.mkdir()
    picture = np.full((48, 64, 3), 20, np.uint8)
    picture[12:20, 24:32] = (250, 120, 30)
    with JpegVideoWriter(folder / "side.avi", size=(64, 48), fps=30.0) as writer:
        for _ in range(6):
            writer.write(picture)
    document = {
        "trial": {"kind": "paws", "name": "square", "fps": 30.0, "frames": [1, 6]},
        "views": [{"name": "side", "video": "side.avi", "points": ["FL"]}],
        "start": {"points": "start.csv"},
    }
    (folder / "trial.toml").write_text(tomli_w.dumps(document))
    (folder / "meta.toml").write_text("threshold_px = 6.0\n")
    marks = pd.DataFrame({"frame": range(6), "view": "side", "point": "FL", "u": 27.5, "v": 15.5})
    marks.assign(visible=1).to_csv(folder / "marks.csv", index=False)
    marks.iloc[[3]].to_csv(folder / "start.csv", index=False)
    return Clip(folder)


def test_marks_stay_on_what_they_mark(clip, tmp_path):
    """The middle of the square in the new picture, told by its centre of mass."""
    import av
    from real_clip_marks import Clip
    from refilm_clips import FILMS, film_clip

    for name in ("as-it-is", "half", "small", "grey"):
        film_clip(clip, tmp_path / name, FILMS[name])
        again = Clip(tmp_path / name)
        with av.open(str(next((tmp_path / name).glob("side.*")))) as container:
            shown = next(container.decode(video=0)).to_ndarray(format="gray").astype(float)
        moments = cv2.moments(np.maximum(shown - 60.0, 0.0))
        middle = np.array([moments["m10"], moments["m01"]]) / moments["m00"]
        own = again.marks[["u", "v"]].to_numpy()
        assert np.abs(own - middle).max() < 0.2, name
        assert again.threshold_px == 6.0 * FILMS[name].scale


def test_every_second_frame_keeps_its_own_marks(clip, tmp_path):
    import tomllib

    from real_clip_marks import Clip
    from refilm_clips import FILMS, film_clip

    film_clip(clip, tmp_path / "fewer", FILMS["half-rate"])
    again = Clip(tmp_path / "fewer")
    assert again.marks["frame"].tolist() == [0, 1, 2]  # 0, 2 and 4 of the clip
    trial = tomllib.loads((tmp_path / "fewer" / "trial.toml").read_text())["trial"]
    assert (trial["fps"], trial["frames"]) == (15.0, [1, 3])
    assert len(again.start) == 1  # frame 3 was clicked, which the film lacks
    assert again.start["frame"].isin(again.marks["frame"]).all()


def test_cameras_see_points_where_marks_are():
    """By the definition of the DLT (Abdel-Aziz & Karara 1971), worked out point by point."""
    from refilm_clips import FILMS, moved, moved_rig

    random = np.random.default_rng(5)
    rig = random.normal(0.0, 1.0, (11, 3))
    rig[8:] *= 0.01

    def seen(coefficients, xyz):
        over = coefficients[8] * xyz[0] + coefficients[9] * xyz[1] + coefficients[10] * xyz[2] + 1
        u = (coefficients[:3] @ xyz + coefficients[3]) / over
        v = (coefficients[4:7] @ xyz + coefficients[7]) / over
        return u, v

    for camera in range(3):
        xyz = random.normal(0.0, 3.0, 3)
        u, v = seen(rig[:, camera], xyz)
        table = pd.DataFrame({"frame": [0], "view": ["a"], "point": ["FL"], "u": [u], "v": [v]})
        wanted = moved(table, FILMS["half"])[["u", "v"]].to_numpy()[0]
        found = seen(moved_rig(rig, FILMS["half"])[:, camera], xyz)
        np.testing.assert_allclose(found, wanted, atol=1e-3)  # places are rounded to that
