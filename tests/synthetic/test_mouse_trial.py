"""A synthetic recording on disk: what is written, and that the truth is true."""

import itertools

import av
import numpy as np
import pandas as pd
import pytest

from pawnb.core import dlt
from pawnb.errors import InputError
from pawnb.schema import EVENTS_COLUMNS, POINTS3D_COLUMNS, START_COLUMNS, TRACKS_COLUMNS
from pawnb.synthetic import render_mouse_trial
from pawnb.synthetic.scene import LEGS
from pawnb.trial import load_trial

pytestmark = pytest.mark.slow  # scenes are rendered and tracked

FPS, FRAMES = 100.0, 30
SMALL = {"fps": FPS}  # 30 frames are one and a half strides


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A normal recording of 30 frames at 100 per second, 512 x 175 px."""
    path = tmp_path_factory.mktemp("normal")
    render_mouse_trial(path, frames=FRAMES, scale=0.25, settings=SMALL)
    return path


@pytest.fixture(scope="module")
def turned(tmp_path_factory):
    """A few frames of an animal that runs towards -X."""
    path = tmp_path_factory.mktemp("turned")
    render_mouse_trial(path, frames=12, scale=0.25, seed=3, settings={**SMALL, "direction": -1})
    return path


def pictures(folder, view):
    with av.open(str(folder / f"{view}.avi")) as container:
        return [f.to_ndarray(format="rgb24").astype(int) for f in container.decode(video=0)]


def redness(folder):
    """Truth with red minus green of the pixel at each paw."""
    tracks = pd.read_csv(folder / "truth/tracks.csv")
    parts = []
    for view, rows in tracks.groupby("view"):
        frames = pictures(folder, view)
        value = [
            np.subtract(*frames[r.frame][round(r.v), round(r.u)][:2]) for r in rows.itertuples()
        ]
        parts.append(rows.assign(red=value))
    return pd.concat(parts)


def coefs(folder):
    return np.loadtxt(folder / "DLTcoefs.csv", delimiter=",")


def test_files_tables_and_trial_are_those_of_the_contract(folder):
    names = {p.relative_to(folder).as_posix() for p in folder.rglob("*") if p.is_file()}
    assert names == {
        "cam1.avi", "cam2.avi", "cam3.avi", "cam4.avi", "DLTcoefs.csv", "start.csv",
        "trial.toml", "truth/tracks.csv", "truth/points3d.csv", "truth/events.csv",
        "truth/landmarks3d.csv",
    }  # fmt: skip
    trial = load_trial(folder)
    assert trial.kind == "paws"
    assert (trial.fps, trial.belt_speed) == (FPS, 300.0)
    assert [v.points for v in trial.views] == [("FR", "HR")] * 2 + [("FL", "HL")] * 2
    assert trial.calibration.forward == (1.0, 0.0, 0.0)
    assert coefs(folder).shape == (11, 4)
    for name, columns, rows in (
        ("tracks", [*TRACKS_COLUMNS, "visible", "visible_fraction"], FRAMES * 4 * 4),
        ("points3d", list(POINTS3D_COLUMNS), FRAMES * 4),
        ("events", [*EVENTS_COLUMNS, "x", "y", "z"], None),
    ):
        table = pd.read_csv(folder / "truth" / f"{name}.csv")
        assert list(table.columns) == columns
        assert rows in (None, len(table))
        assert not table.isna().any().any()
    for view in ("cam1", "cam4"):
        frames = pictures(folder, view)
        assert len(frames) == FRAMES
        assert frames[0].shape == (175, 512, 3)


def test_image_positions_are_the_projections_of_the_points_in_space(folder):
    tracks = pd.read_csv(folder / "truth/tracks.csv")
    space = pd.read_csv(folder / "truth/points3d.csv").set_index(["frame", "point"])
    for number, (_, rows) in enumerate(tracks.groupby("view")):
        at = space.loc[list(zip(rows["frame"], rows["point"], strict=True)), ["x", "y", "z"]]
        uv = dlt.project(coefs(folder)[:, [number]], at.to_numpy())[:, 0]
        np.testing.assert_allclose(uv, rows[["u", "v"]], atol=1e-7)


@pytest.mark.parametrize(("name", "sign"), [("folder", 1.0), ("turned", -1.0)])
def test_between_touch_down_and_lift_off_paws_move_exactly_with_the_belt(name, sign, request):
    folder = request.getfixturevalue(name)
    space = pd.read_csv(folder / "truth/points3d.csv")
    events = pd.read_csv(folder / "truth/events.csv")
    checked = 0
    for leg in LEGS:
        path = space[space["point"] == leg].set_index("frame")[["x", "y", "z"]]
        own = events[(events["leg"] == leg) & events["event"].isin(["TD", "LO"])]
        for a, b in itertools.pairwise(path.index):
            before, after = own[own["frame"] <= a], own[own["frame"] > a]
            if len(own) == 0 or (after["frame"] <= b).any():
                continue  # nothing is known of this leg, or the paw lands or lifts between
            stands = (
                before.iloc[-1]["event"] == "TD" if len(before) else after.iloc[0]["event"] == "LO"
            )
            step = path.loc[b] - path.loc[a]
            assert np.allclose(step, [-sign * 300.0 / FPS, 0.0, 0.0], atol=1e-9) == stands
            checked += 1
    assert checked > len(space) / 2


def test_events_come_in_order_with_times_and_places(folder):
    events = pd.read_csv(folder / "truth/events.csv")
    order = ["TD", "LO", "PEP", "AEP"]
    for leg in LEGS:
        own = events[events["leg"] == leg]
        assert len(own) >= 4
        assert own["frame"].is_monotonic_increasing
        place = [order.index(e) for e in own["event"]]
        assert all((b - a) % 4 == 1 for a, b in itertools.pairwise(place))
        # AEP comes before touch-down by the retraction of the leg: a hundredth of a second
        aep, td = (own.loc[own["event"] == e, "time_s"].to_numpy() for e in ("AEP", "TD"))
        gap = [t - aep[aep < t].max() for t in td if (aep < t).any()]
        assert all(0 < g < 0.02 for g in gap)
    np.testing.assert_allclose(events["time_s"] * FPS, events["frame"])
    on_belt = events[events["event"].isin(["TD", "LO"])]
    np.testing.assert_allclose(on_belt["z"], 1.2)


def test_every_paw_hides_and_crosses_others(folder):
    tracks = pd.read_csv(folder / "truth/tracks.csv")
    assert (tracks.groupby("point")["visible_fraction"].min() < 0.05).all()
    # the front paw hides even from its own side, early in swing
    own_side = {"FR": ("cam1", "cam2"), "FL": ("cam3", "cam4")}
    for leg, views in own_side.items():
        seen = tracks[(tracks["point"] == leg) & tracks["view"].isin(views)]
        hidden = (seen["visible"] == 0).groupby(seen["view"]).mean()
        assert hidden.min() > 0.05
        assert hidden.max() < 0.4
    for _, view in tracks.groupby("view"):
        u = view.pivot_table(index="frame", columns="point", values="u")
        v = view.pivot_table(index="frame", columns="point", values="v")
        for a, b in (("FR", "FL"), ("HR", "HL")):
            assert (np.diff(np.sign(u[a] - u[b])) != 0).sum() >= 2
    for hind, front, view in (("HR", "FR", "cam1"), ("HL", "FL", "cam3")):
        here = tracks[tracks["view"] == view]
        u, v = (here.pivot_table(index="frame", columns="point", values=c) for c in "uv")
        # closer than the paper's window is wide (70 px at full scale) by far
        assert np.hypot(u[hind] - u[front], v[hind] - v[front]).min() < 30 * 0.25


@pytest.mark.parametrize("name", ["folder", "turned"])
def test_visible_paws_are_pink_and_hidden_ones_are_not_there(name, request):
    table = redness(request.getfixturevalue(name))
    seen = table.loc[table["visible_fraction"] > 0.9, "red"]
    hidden = table.loc[table["visible_fraction"] < 0.02, "red"]
    assert len(seen) > 40
    assert seen.median() > 20
    # fur has no colour and the belt is green
    assert (seen > 5).mean() > 0.9
    assert len(hidden) >= 3
    assert hidden.median() < 3
    assert (hidden < 12).mean() > 0.9


def test_start_clicks_are_the_truth_in_whole_pixels(folder):
    start = pd.read_csv(folder / "start.csv")
    assert tuple(start.columns) == START_COLUMNS
    assert len(start) == 8  # all paws are visible where they are tracked
    tracks = pd.read_csv(folder / "truth/tracks.csv")
    both = start.merge(tracks, on=["frame", "view", "point"], suffixes=("", "_true"))
    assert len(both) == 8
    assert (both["frame"] == 0).all()
    assert (both["visible_fraction"] > 0.6).all()
    for axis in "uv":
        assert (both[axis] == both[axis].round()).all()
        assert (both[axis] - both[f"{axis}_true"]).abs().max() <= 0.5


def test_an_animal_that_runs_the_other_way(turned):
    trial = load_trial(turned)
    assert [v.points for v in trial.views] == [("FL", "HL")] * 2 + [("FR", "HR")] * 2
    assert trial.calibration.forward == (-1.0, 0.0, 0.0)
    space = pd.read_csv(turned / "truth/points3d.csv")
    mean = space.groupby("point")[["x", "y"]].mean()
    assert mean.loc["FR", "x"] < mean.loc["HR", "x"]  # front is towards -X
    assert mean.loc["FR", "y"] > mean.loc["FL", "y"]  # and its right towards +Y


@pytest.mark.parametrize("n_views", [2, 3])
def test_fewer_views(tmp_path, n_views):
    render_mouse_trial(
        tmp_path, frames=2, scale=0.1, difficulty="easy", settings={"n_views": n_views}
    )
    trial = load_trial(tmp_path)
    assert [v.points for v in trial.views] == [("FR", "HR"), ("FR", "HR"), ("FL", "HL")][:n_views]
    assert coefs(tmp_path).shape == (11, n_views)
    assert sorted(p.name for p in tmp_path.glob("*.avi")) == [
        f"cam{i}.avi" for i in range(1, n_views + 1)
    ]


def test_the_same_seed_gives_the_same_bytes_and_another_does_not(tmp_path):
    for name, seed in (("a", 5), ("b", 5), ("c", 6)):
        render_mouse_trial(tmp_path / name, frames=3, scale=0.1, seed=seed, difficulty="hard")
    files = [p.relative_to(tmp_path / "a") for p in (tmp_path / "a").rglob("*") if p.is_file()]
    assert len(files) == 11
    for file in files:
        first = (tmp_path / "a" / file).read_bytes()
        assert first == (tmp_path / "b" / file).read_bytes(), file
        assert first != (tmp_path / "c" / file).read_bytes(), file


def test_progress_counts_to_the_end(tmp_path):
    calls = []
    path = render_mouse_trial(
        tmp_path, frames=5, scale=0.05, progress=lambda done, total: calls.append((done, total))
    )
    assert calls == [(k, 5) for k in range(1, 6)]
    assert path == tmp_path / "trial.toml"


def test_a_run_that_is_stopped_leaves_no_trial(tmp_path):
    render_mouse_trial(tmp_path, frames=2, scale=0.05)

    def stop(done, total):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        render_mouse_trial(tmp_path, frames=5, scale=0.05, progress=stop)
    assert not (tmp_path / "trial.toml").exists()


def test_one_frame_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"^frames is 1; expected 2 or more\.$"):
        render_mouse_trial(tmp_path, frames=1)
