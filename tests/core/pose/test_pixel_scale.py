"""px per unit, from grids painted with a known spacing and from clicks."""

import cv2
import numpy as np
import pytest
from painted_spider import coverage, panel

from pawnb.core.pose.pixel_scale import scale_from_clicks, scale_from_grid
from pawnb.core.pose.poses import natural_pose
from pawnb.core.pose.species_file import load_species
from pawnb.errors import InputError

SIZE = (640, 512)


def grid(pitch, angle_deg, rng, *, depth=0.05, width=0.8, noise=2.0, size=SIZE, stretch=1.0):
    """Paint a grid of dark lines ``pitch`` px apart on a vignetted panel."""
    v, u = np.mgrid[: size[1], : size[0]].astype(float)
    turn = np.radians(angle_deg)
    picture = panel(size)
    for more, phase, apart in ((0.0, 0.3, pitch), (np.pi / 2, 0.7, pitch * stretch)):
        x = (u - 320) * np.cos(turn + more) + (v - 256) * np.sin(turn + more)
        off = ((x / apart - phase + 0.5) % 1 - 0.5) * apart
        picture = picture * (1 - depth * np.exp(-0.5 * (off / width) ** 2))
    return np.clip(picture + rng.normal(0, noise, picture.shape), 0, 255).round().astype(np.uint8)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("pitch", "angle", "depth", "noise"),
    [
        (23.7, 3.3, 0.05, 2.0),
        (48.02, -31.0, 0.02, 2.0),  # two grey values deep under noise of two
        (12.31, 17.0, 0.05, 4.0),
        (90.4, 0.0, 0.2, 1.0),
        (61.5, 44.0, 0.02, 1.0),
    ],
)
def test_a_painted_grid_is_measured_to_a_thousandth(pitch, angle, depth, noise):
    picture = grid(pitch, angle, np.random.default_rng(3), depth=depth, noise=noise)
    found = scale_from_grid(picture, spacing=10.0)
    assert found.px_per_unit == pytest.approx(pitch / 10, rel=1e-3)
    assert abs(found.px_per_unit - pitch / 10) < 5 * found.sd
    assert found.sd < 1e-3 * pitch / 10
    assert abs((found.angle_deg - angle + 45) % 90 - 45) < 0.2
    # lines of two directions across the picture, counted by hand: its extent over the pitch
    turn = np.radians(angle)
    wide = [abs(640 * np.cos(t)) + abs(512 * np.sin(t)) for t in (turn, turn + np.pi / 2)]
    for n, extent in zip(sorted(found.n_lines), sorted(wide), strict=True):
        assert 0.6 * extent / pitch < n <= extent / pitch + 1


@pytest.mark.parametrize(
    ("pitch", "width", "depth"),
    [
        (24.0, 0.8, 0.05),  # taken for every second line
        (7.3, 0.5, 0.05),  # for every third
        (7.3, 2.0, 0.3),  # for every tenth: the grid repeats itself in 73 whole pixels
    ],
)
def test_several_lines_are_not_taken_for_one_period(pitch, width, depth):
    picture = grid(pitch, 0.0, np.random.default_rng(1), width=width, depth=depth, size=(480, 384))
    found = scale_from_grid(picture, spacing=10.0)
    assert found.px_per_unit == pytest.approx(pitch / 10, rel=2e-3)


def test_bright_lines_and_a_spider_on_the_grid_do_no_harm():
    rng = np.random.default_rng(0)
    animal = load_species("dolomedes")
    picture = 255 - grid(30.25, 12.0, rng).astype(float)
    share = coverage(animal, natural_pose(animal, xy=(300.0, 240.0), scale=2.4), SIZE)
    picture = np.clip(picture * (1 - share) + 20 * share, 0, 255).astype(np.uint8)
    assert scale_from_grid(picture, spacing=5).px_per_unit == pytest.approx(6.05, rel=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_walls_far_stronger_than_the_grid_do_no_harm(seed):
    # an arena with bright walls, dark outside: edges have all frequencies of their direction
    rng = np.random.default_rng(seed)
    pitch = 24.2
    picture = grid(pitch, 0.15, rng, depth=0.06, width=0.6, noise=0.0).astype(float)
    picture[:100] = picture[410:] = 15.0
    for v in (126, 130, 382, 386):
        picture[v : v + 2] = 235.0 if v in (126, 386) else 60.0
    picture = np.clip(picture + rng.normal(0, 1, picture.shape), 0, 255).astype(np.uint8)
    found = scale_from_grid(picture, spacing=10.0)
    assert found.px_per_unit == pytest.approx(pitch / 10, rel=3e-3)
    assert sum(found.n_lines) > 25


def test_colour_and_jpeg():
    picture = grid(37.4, 5.0, np.random.default_rng(5))
    _, data = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, 60])
    colour = cv2.imdecode(data, cv2.IMREAD_COLOR)
    assert scale_from_grid(colour, spacing=1).px_per_unit == pytest.approx(37.4, rel=1e-3)


@pytest.mark.parametrize("seed", range(4))
def test_no_grid_is_said_plainly(seed):
    rng = np.random.default_rng(seed)
    noisy = panel(SIZE) + rng.normal(0, 3, (512, 640))
    blurred = cv2.GaussianBlur(noisy, (0, 0), 1 + seed)
    animal = load_species("dolomedes")
    spider = panel(SIZE) * (
        1 - coverage(animal, natural_pose(animal, xy=(320, 256), scale=2.4), SIZE)
    )
    for picture in (noisy, blurred, spider):
        with pytest.raises(InputError, match="no grid was found"):
            scale_from_grid(np.clip(picture, 0, 255).astype(np.uint8), spacing=10)


def test_lines_in_one_direction_are_no_grid():
    u = np.arange(640.0)
    stripes = panel(SIZE) * (1 - 0.1 * (np.abs((u % 40) - 20) < 1))
    with pytest.raises(InputError, match="no grid was found"):
        scale_from_grid(stripes.astype(np.uint8), spacing=10)


@pytest.mark.slow
def test_a_camera_that_looks_from_the_side_is_refused():
    picture = grid(40.0, 0.0, np.random.default_rng(1), stretch=1.2)
    with pytest.raises(InputError, match=r"from the side|no grid"):
        scale_from_grid(picture, spacing=10)


def test_two_clicks():
    # a 3-4-5 triangle: 500 px for 100 mm; each click off by 1 px SD in u and v, so that the
    # distance has an SD of sqrt(2) px (propagation of errors)
    found = scale_from_clicks((10, 20), (310, 420), distance=100.0)
    assert found.px_per_unit == pytest.approx(5.0)
    assert found.sd == pytest.approx(2**0.5 / 100)
    rng = np.random.default_rng(0)
    lengths = np.hypot(*(rng.normal((300, 400), 2**0.5, (20000, 2))).T)
    assert found.sd == pytest.approx(lengths.std() / 100, rel=0.03)
    assert found.text("mm") == "5 ± 0.014 px per mm"


@pytest.mark.parametrize("distance", [0.0, -1.0, float("nan")])
def test_a_distance_that_cannot_be(distance):
    with pytest.raises(InputError, match="expected more than 0"):
        scale_from_clicks((0, 0), (100, 0), distance=distance)
    with pytest.raises(InputError, match="expected more than 0"):
        scale_from_grid(np.zeros((50, 50), np.uint8), spacing=distance)


def test_two_clicks_on_one_place():
    with pytest.raises(InputError, match="far from each other"):
        scale_from_clicks((10, 10), (11, 11), distance=5.0)
