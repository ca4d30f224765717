"""Rendered scenes that shine, blur, turn dark or are seen from below; the truth stays."""

import dataclasses

import numpy as np
import pandas as pd
import pytest

from pawnb.core.video import open_views
from pawnb.synthetic import render_mouse_trial
from pawnb.synthetic.camera import make_cameras
from pawnb.synthetic.gait_model import plan_gait
from pawnb.synthetic.lamps import cast_shadow
from pawnb.synthetic.mirrors import find_mirrors
from pawnb.synthetic.mouse import PAW, Mouse
from pawnb.synthetic.render import ViewRenderer
from pawnb.synthetic.scene import LEGS, scene_settings
from pawnb.trial import load_trial

SHORT = {"frames": 4, "scale": 0.1, "seed": 2, "settings": {"fps": 40.0}}  # half a stride
QUIET = {"scale": 0.25, "read_noise": 0.0, "shot_noise": 0.0, "blur_px": 0.0, "belt_marks": 0.0}


def make_scene(**changes):
    settings = scene_settings(changes={**QUIET, **changes})
    gait = plan_gait(settings, 0.5)
    return settings, make_cameras(settings), Mouse(settings, gait), gait


def picture(settings, camera, moments):
    (mesh, time_s), *others = moments
    image, _ = ViewRenderer(camera, settings, 0).render(
        mesh, cast_shadow(mesh, settings), frame=0, time_s=time_s,
        others=[(m, cast_shadow(m, settings), t) for m, t in others],
    )  # fmt: skip
    return image.astype(float)


@pytest.mark.slow
def test_a_mirror_image_lies_where_a_mirror_puts_it_and_nowhere_else():
    settings, cameras, mouse, _ = make_scene(reflections=0.5)
    plain = dataclasses.replace(settings, reflections=0.0)
    mesh = mouse.mesh(1.0)
    for camera in (cameras[0], cameras[2]):
        changed = np.abs(
            picture(settings, camera, [(mesh, 1.0)]) - picture(plain, camera, [(mesh, 1.0)])
        ).max(axis=2)
        # by the law of reflection: as far behind the far wall, at y = -side 62, and under the belt
        wall = mesh.vertices * [1, -1, 1] + [0, -2 * camera.side * 62.0, 0]
        belt = mesh.vertices * [1, 1, -1]
        expected = np.zeros(changed.shape, bool)
        for vertices in (wall, belt):
            u, v = np.round(camera.project(vertices)[0]).astype(int).T
            inside = (u >= 0) & (v >= 0) & (u < settings.width) & (v < settings.height)
            for du in range(-3, 4):
                for dv in range(-3, 4):
                    at = np.clip([v[inside] + dv, u[inside] + du], 0, [[174], [511]])
                    expected[tuple(at)] = True
        assert (changed > 4).sum() > 500
        assert ((changed > 4) & ~expected).sum() == 0


def test_an_image_is_the_animal_turned_inside_out_behind_the_mirror():
    settings, cameras, mouse, _ = make_scene(reflections=0.5)
    wall, belt = find_mirrors(cameras[0], settings)  # stands at -Y: the far wall is at +62
    mesh = mouse.mesh(1.0)
    np.testing.assert_allclose(wall.image(mesh).vertices, mesh.vertices * [1, -1, 1] + [0, 124, 0])
    np.testing.assert_allclose(belt.image(mesh).normals, mesh.normals * [1, 1, -1])

    def volume(mesh):
        a, b, c = np.moveaxis(mesh.vertices[mesh.faces] - mesh.vertices.mean(axis=0), 1, 0)
        return np.einsum("ij,ij->", a, np.cross(b, c)) / 6

    # its faces still look outwards: with the corners in the same order it would be negative
    assert volume(wall.image(mesh)) == pytest.approx(volume(mesh))
    assert abs(volume(mesh)) > 10_000


def test_the_belt_shines_no_farther_than_it_reaches():
    settings, cameras, *_ = make_scene(reflections=0.5)
    (_, belt) = find_mirrors(cameras[0], settings)
    for y, share in ((0.0, 0.5), (-55.0, 0.5), (-70.0, 0.0), (70.0, 0.0)):
        u, v = cameras[0].project(np.array([0.0, y, 0.0]))[0].round().astype(int)
        assert belt.share[v, u] == pytest.approx(share)


@pytest.mark.slow
def test_an_open_shutter_gives_the_mean_of_what_it_sees():
    settings, cameras, mouse, _ = make_scene(shutter=0.5)
    moments = [(mouse.mesh(t), t) for t in (1.0, 1.01, 1.02)]
    mean = np.mean([picture(settings, cameras[0], [moment]) for moment in moments], axis=0)
    # each picture is rounded to half a grey level
    assert np.abs(picture(settings, cameras[0], moments) - mean).max() <= 1.01


def test_paws_turn_dark_at_lift_off_only():
    _, _, mouse, gait = make_scene(covered_paws=0.9)
    motion = gait.legs["HR"]
    k = int(np.searchsorted(motion.touch_down_s, 1.0))
    stance = motion.touch_down_s[k], motion.lift_off_s[k]
    middle, lift = 0.5 * sum(stance), stance[1]
    landed = motion.touch_down_s[k + 1] + 1e-4

    def colour(time_s):
        mesh = mouse.mesh(time_s)
        return mesh.colour[np.unique(mesh.faces[mesh.part == PAW["HR"]])].mean(axis=0)

    bare = colour(middle)
    assert bare[0] - bare[1] > 25  # pink
    np.testing.assert_allclose(colour(landed), bare)
    dark = colour(lift)
    assert abs(dark[0] - dark[1]) < 8
    assert dark.mean() < 0.5 * bare.mean()
    other = mouse.mesh(lift)
    at_rest = other.colour[np.unique(other.faces[other.part == PAW["HL"]])].mean(axis=0)
    np.testing.assert_allclose(at_rest, bare)  # trots: the other hind paw stands


def test_all_paws_are_seen_from_below_before_the_belly():
    settings, cameras, mouse, gait = make_scene(below=True, n_views=2)
    mesh = mouse.mesh(1.0)
    image = picture(settings, cameras[0], [(mesh, 1.0)])
    for leg in LEGS:
        point = gait.legs[leg].position(np.array([1.0]))[0]
        u, v = cameras[0].project(point)[0].round().astype(int)
        red, green, _ = image[v, u]
        assert red - green > 10, leg
    # right is right: seen from below the animal's right paws are on the other side than from above
    right, left = (cameras[0].project(np.array([0.0, y, 0.0]))[0] for y in (-20.0, 20.0))
    ahead = cameras[0].project(np.array([30.0, 0.0, 0.0]))[0]
    assert ahead[0] > right[0]
    assert right[1] < left[1]
    assert all(camera.centre[2] < -300 for camera in cameras)


@pytest.mark.slow
@pytest.mark.parametrize(
    "variants",
    [
        ["grey"], ["grey", "h264-crf28"], ["motion-blur", "covered-lift-off"],
        ["white-mouse", "reflections", "flicker"],
    ],
)  # fmt: skip
def test_the_truth_stays(tmp_path, rendered_short, variants):
    render_mouse_trial(tmp_path, **SHORT, variants=variants)
    for name in ("tracks", "points3d", "events", "landmarks3d"):
        usual, here = (
            (folder / "truth" / f"{name}.csv").read_text() for folder in (rendered_short, tmp_path)
        )
        if name == "events":  # a column names the trial
            usual = usual.replace(
                "synthetic-normal-02", "-".join(["synthetic-normal-02", *variants])
            )
        assert here == usual
    with open_views(load_trial(rendered_short)) as usual, open_views(load_trial(tmp_path)) as here:
        assert here.n_frames == SHORT["frames"]
        pairs = [
            (usual.readers[name].read(frame), here.readers[name].read(frame)[:70, :205])
            for name in usual.names for frame in range(SHORT["frames"])
        ]  # fmt: skip
    if "grey" in variants:
        for image in (image for _, image in pairs if image.ndim == 3):
            assert np.abs(image - image.mean(axis=2, keepdims=True)).max() <= 2.0
    else:
        assert max(np.abs(a.astype(int) - b).max() for a, b in pairs) > 30


@pytest.fixture(scope="module")
def rendered_short(tmp_path_factory):
    folder = tmp_path_factory.mktemp("usual")
    render_mouse_trial(folder, **SHORT)
    return folder


@pytest.mark.slow
def test_a_low_rate_shows_every_fifth_of_the_same_frames(tmp_path):
    usual, low = tmp_path / "usual", tmp_path / "low"
    render_mouse_trial(usual, frames=16, scale=0.1, seed=2)
    render_mouse_trial(low, frames=4, scale=0.1, seed=2, variants=["low-rate"])
    assert load_trial(low).fps == load_trial(usual).fps / 5
    all_frames, some = (pd.read_csv(f / "truth" / "points3d.csv") for f in (usual, low))
    kept = all_frames[all_frames["frame"] % 5 == 0].reset_index(drop=True)
    np.testing.assert_allclose(some[["x", "y", "z"]], kept[["x", "y", "z"]], atol=1e-9)


@pytest.mark.slow
def test_a_trial_from_below_can_be_opened_and_clicked(tmp_path):
    render_mouse_trial(tmp_path, frames=2, scale=0.15, variants=["glass-belt", "h264-crf23"])
    trial = load_trial(tmp_path)
    assert trial.name == "synthetic-normal-00-glass-belt-h264-crf23"
    assert [view.video for view in trial.views] == ["cam1.mp4", "cam2.mp4"]
    start = pd.read_csv(tmp_path / "start.csv")
    assert sorted(start["point"].unique()) == sorted(LEGS)
    assert len(start) >= 6
