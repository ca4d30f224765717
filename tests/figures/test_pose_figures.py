"""A pose over its picture, and leg angles over time."""

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest

from pawnb.errors import InputError
from pawnb.figures import build_pose_overlay_table, plot_leg_angles, plot_pose_overlay
from pawnb.schema import make_tracks


@pytest.fixture
def tracks():
    """Two legs of two segments; leg R1 goes straight to the right of (10, 20)."""
    points = ["body", "L1", "R1", "L1.BC", "L1.CF", "R1.BC", "R1.CF"]
    tracks = make_tracks([4, 5], points, fps=100, views=["top"], space=("x", "y"))
    place = tracks["image_position"].to_numpy()
    for name, uv in {"R1.BC": (10, 20), "R1.CF": (14, 20), "R1": (19, 20),
                     "L1.BC": (8, 20), "L1.CF": (4, 22), "L1": (0, 25)}.items():  # fmt: skip
        place[1, 0, :, points.index(name), 0] = uv
    return tracks


def test_legs_go_from_the_body_to_the_tip(tracks):
    table = build_pose_overlay_table(tracks, frame=5)
    assert table["leg"].tolist() == ["L1"] * 3 + ["R1"] * 3
    assert table["joint"].tolist() == ["BC", "CF", "tip"] * 2
    assert table[table["leg"] == "R1"]["u"].tolist() == [10, 14, 19]
    ax = plot_pose_overlay(table, picture=np.zeros((40, 30), np.uint8))
    assert sorted(line.get_xdata().tolist() for line in ax.lines) == [[8, 4, 0], [10, 14, 19]]
    top, bottom = ax.get_ylim()[::-1]
    assert top < 20 < 25 < bottom  # v is down
    assert [text.get_text() for text in ax.texts] == ["L1", "R1"]
    plt.close("all")


def test_the_name_of_a_leg_lies_on_no_part_of_it(tracks):
    ax = plot_pose_overlay(build_pose_overlay_table(tracks, frame=5))
    ax.figure.canvas.draw()
    for text, line in zip(ax.texts, ax.lines, strict=True):
        u, v = line.get_data()
        along = np.linspace(0, len(u) - 1, 200)
        own = np.stack([np.interp(along, range(len(u)), xs) for xs in (u, v)], axis=1)
        box = text.get_window_extent()
        assert not box.count_contains(ax.transData.transform(own))
    plt.close("all")


def test_a_frame_without_a_pose_and_points_without_joints_are_refused(tracks):
    with pytest.raises(InputError, match="frame 9 is not tracked; choose one of 4 to 5"):
        build_pose_overlay_table(tracks, frame=9)
    with pytest.raises(InputError, match="no joint has a place"):
        plot_pose_overlay(build_pose_overlay_table(tracks, frame=4))
    with pytest.raises(InputError, match="no joints such as"):
        build_pose_overlay_table(tracks.sel(keypoint=["body", "L1"]), frame=5)


def test_leg_angles_and_their_extremes():
    time = np.linspace(0, 1, 11)
    table = pd.DataFrame({"time_s": time, "leg": "L2", "leg_angle": 30 * np.sin(6 * time)})
    events = pd.DataFrame({"leg": ["L2", "L2", "L1"], "event": ["AEP", "PEP", "AEP"],
                           "time_s": [0.3, 0.8, 0.5]})  # fmt: skip
    ax = plot_leg_angles(table, events=events)
    curve, aep, pep = ax.lines
    assert curve.get_ydata().tolist() == table["leg_angle"].tolist()
    assert (aep.get_xdata().tolist(), aep.get_marker()) == ([0.3], "^")
    assert aep.get_ydata()[0] == pytest.approx(30 * np.sin(1.8))
    assert pep.get_xdata().tolist() == [0.8]
    both = plot_leg_angles(pd.concat([table, table.assign(leg="R2"), table.assign(leg="L6")]))
    second, across, sixth = both.lines
    assert second.get_color() != across.get_color()
    # the legs of one side have four colours
    assert second.get_color() == sixth.get_color()
    assert [line.get_linestyle() for line in both.lines] == ["-", "-", "--"]
    plt.close("all")
    with pytest.raises(InputError, match="table is empty"):
        plot_leg_angles(table.iloc[:0])
