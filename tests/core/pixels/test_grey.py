"""What counts as a grey picture, of films whose colours are compressed."""

import av
import numpy as np
import pytest

from pawnb.core.pixels.grey import has_colour


def decoded(*, cb: int, cr: int) -> np.ndarray:
    """RGB of a picture with every brightness and one pair of colour differences (128: none).

    Made by FFmpeg's conversion, as a film would be.
    """
    bright = np.repeat(np.arange(256, dtype=np.uint8)[:, None], 16, axis=1)
    colours = [np.full(256 * 16 // 4, value, np.uint8) for value in (cb, cr)]
    planes = np.concatenate([bright.ravel(), *colours]).reshape(-1, 16)
    return av.VideoFrame.from_ndarray(planes, format="yuv420p").to_ndarray(format="rgb24")


@pytest.mark.parametrize(("cb", "cr"), [(128, 128), (127, 129), (126, 127), (126, 130), (130, 126)])
def test_a_tint_of_two_steps_is_no_colour(cb, cr):
    # H.264 leaves colour differences of a grey film one or two steps off: 126 and 127 are those of
    # mouse_below_grey
    assert not has_colour(decoded(cb=cb, cr=cr))


@pytest.mark.parametrize(("cb", "cr"), [(122, 128), (128, 134), (120, 140)])
def test_a_pale_colour_is_one(cb, cr):
    assert has_colour(decoded(cb=cb, cr=cr))


@pytest.mark.parametrize(
    ("folder", "film", "coloured"),
    [
        ("real-clips/mouse_below_grey", "below.mp4", False),
        ("mouse-4cam-cage", "cam2_mid.mp4", False),
        ("real-clips/horse_walk", "side.mp4", True),
    ],
)
def test_real_films(real_data, folder, film, coloured):
    # what they are is what their descriptions say: infrared, "grey cameras", a film of a dark horse
    with av.open(str(real_data(folder) / film)) as video:
        picture = next(video.decode(video=0)).to_ndarray(format="rgb24")
    assert has_colour(picture) == coloured
