"""The stride template on paths with known shape, and its fit with known parameters."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pawnb.core.parameters import parameters_set
from pawnb.core.paws.maghsoudi2019.template import (
    KindTemplate,
    StrideTemplate,
    average_strides,
    cut_strides,
    load_template,
    lowpass_path,
)
from pawnb.core.paws.maghsoudi2019.template_fit import fit_template
from pawnb.errors import InputError
from pawnb.schema import ORIGIN_CODE, make_tracks

FPS = 250.0
FRONT = {"FR": "front", "HR": "hind"}
SHARE = np.arange(50) / 50


def shape(phase):
    """A stride: u falls slowly and rises fast, v lifts while u rises; range of u is 1."""
    angle = 2 * np.pi * np.asarray(phase)
    u = np.cos(angle + 0.4 * np.sin(angle)) / 2
    v = -0.2 * np.maximum(np.sin(-angle), 0.0) ** 2
    return np.stack([u, v], axis=-1)


def walking(*, facing=1, period=40.0, amplitude=80.0, n=300, drift=0.1, noise=0.0, lost=()):
    """Tracks of two paws half a stride apart that walk towards ``facing``."""
    t = np.arange(n)
    tracks = make_tracks(t, ["FR", "HR"], fps=FPS, views=["cam1"])
    for p in (0, 1):
        path = amplitude * shape(t / period + 0.5 * p)
        path[:, 0] += drift * t
        path += np.random.default_rng(p).normal(0, noise, path.shape)
        tracks["image_position"][:, 0, 0, p, 0] = 500 + facing * path[:, 0]
        tracks["image_position"][:, 0, 1, p, 0] = 200 + path[:, 1]
    tracks["image_origin"][:] = ORIGIN_CODE["measured"]
    for frame in lost:
        tracks["image_position"][frame] = 0.0
        tracks["image_origin"][frame] = ORIGIN_CODE["predicted"]
    return tracks


@pytest.mark.parametrize("facing", [1, -1])
def test_the_mean_stride_is_the_path_that_was_walked(facing):
    tracks = walking(facing=facing, noise=0.5)
    strides = cut_strides(tracks, points=FRONT, facing={"cam1": facing})
    template = average_strides([strides, strides])
    for kind in ("front", "hind"):
        own = template.kinds[kind]
        assert own.n_strides == 2 * len(strides[kind].uv) >= 10
        assert own.period_s == pytest.approx(40 / FPS, rel=0.01)
        true = shape(SHARE)
        # closed paths without the drift; the phase counts from the anterior extreme
        lag = np.argmax(true[:, 0])
        true = np.roll(true, -lag, axis=0)
        mid = (true.max(axis=0) + true.min(axis=0)) / 2
        np.testing.assert_allclose(own.uv, true - mid, atol=0.03)


def test_strides_with_predicted_frames_are_left_out():
    whole = cut_strides(walking(), points=FRONT, facing={"cam1": 1})
    gap = cut_strides(walking(lost=range(100, 110)), points=FRONT, facing={"cam1": 1})
    assert len(gap["front"].uv) == len(whole["front"].uv) - 1
    np.testing.assert_allclose(gap["front"].uv.mean(axis=0), whole["front"].uv.mean(axis=0),
                               atol=0.01)  # fmt: skip


def test_gaps_are_bridged_as_long_as_is_set():
    path = walking()["image_position"].to_numpy()[:, 0, :, 0, 0].copy()
    path[100:103] = np.nan
    assert np.isfinite(lowpass_path(path, cutoff_hz=30.0, fps=FPS)).all()
    with parameters_set({"maghsoudi2019": {"template_gap": 2}}):
        assert np.isnan(lowpass_path(path, cutoff_hz=30.0, fps=FPS)[100:103]).all()


def hidden_in_every_stride(origin):
    """Paws that walk, and that no picture shows in 10 of every 40 frames."""
    tracks = walking()
    rows = np.arange(300) % 40 >= 30
    tracks["image_origin"][rows] = ORIGIN_CODE[origin]
    return tracks


@pytest.mark.parametrize("origin", ["predicted", "reprojected"])
def test_a_paw_that_is_hidden_in_every_stride_has_strides_where_its_place_is_known(origin):
    """The truth has such a paw's place from space; a filter's guess is no place."""
    whole = cut_strides(walking(), points=FRONT, facing={"cam1": 1})
    tracks = hidden_in_every_stride(origin)
    strides = cut_strides(tracks, points=FRONT, facing={"cam1": 1})
    if origin == "predicted":
        assert len(strides["front"].uv) == 0
        return
    np.testing.assert_array_equal(strides["front"].uv, whole["front"].uv)
    tracks["origin"][:] = ORIGIN_CODE["predicted"]
    assert len(cut_strides(tracks, points=FRONT, facing={"cam1": 1})["front"].uv) == 0


@pytest.mark.parametrize("origin", ["predicted", "reprojected"])
@pytest.mark.parametrize(("sd", "is_known"), [(1.0, True), (10.0, False)])
def test_bridged_places_count_where_they_are_surely_known(origin, sd, is_known):
    """The paws range over 80 px: a tenth of it, 8 px, is the limit."""
    whole = cut_strides(walking(), points=FRONT, facing={"cam1": 1})
    tracks = hidden_in_every_stride(origin)
    tracks["position"][:, :2] = tracks["image_position"].isel(view=0).to_numpy()
    tracks["position"][:, 2:] = 0.0
    tracks["sd"] = tracks["position"].copy(data=np.zeros(tracks["position"].shape))
    tracks["sd"][:, 0] = sd
    strides = cut_strides(tracks, points=FRONT, facing={"cam1": 1})
    if is_known:
        np.testing.assert_array_equal(strides["front"].uv, whole["front"].uv)
    else:
        assert len(strides["front"].uv) == 0


def test_no_stride_of_a_kind_is_refused():
    strides = cut_strides(walking(), points={"FR": "front"}, facing={"cam1": 1})
    with pytest.raises(InputError, match="no complete stride of a hind paw"):
        average_strides([strides])
    # nor where the direction of travel is unknown
    assert len(cut_strides(walking(), points=FRONT, facing={})["front"].uv) == 0


TEMPLATE = KindTemplate(shape(SHARE), 50 / FPS, 10)


def test_the_spline_is_cubic_closed_and_goes_through_the_means():
    """Eq. 2: cubic between knots; closed means that it and two derivatives go on at the wrap."""
    spline = TEMPLATE.spline
    np.testing.assert_allclose(spline(SHARE), TEMPLATE.uv, atol=1e-12)
    assert spline.c.shape[0] == 4
    for order in (0, 1, 2):
        np.testing.assert_allclose(spline(0.0, order), spline(1.0, order), atol=1e-8)


# the same draws each time: about one in thousands makes the paper's simplex search stop too early
@pytest.mark.slow
@settings(deadline=None, max_examples=25, derandomize=True)
@given(
    period=st.floats(32.0, 75.0),
    amplitude=st.floats(20.0, 200.0),
    shift=st.floats(0.0, 1.0),
    facing=st.sampled_from([1, -1]),
)
def test_fit_finds_shift_frequency_and_amplitude(period, amplitude, shift, facing):
    """Eq. 7 to 9 on a path of known parameters: the next 10 frames are foretold."""
    t = np.arange(150)
    true = amplitude * shape(t / period + shift) * [facing, 1] + [400, 100]
    fit = fit_template(TEMPLATE, true[:140], facing=facing, fps=FPS, cutoff_hz=60.0)
    assert fit is not None
    away = np.linalg.norm(fit.predict(t[140:]) - true[140:], axis=1)
    # the low-pass filter leans on its assumption at the end, and rounds the quick turns
    assert away.max() < 0.12 * amplitude
    if period < 48:
        # a whole stride was seen
        assert fit.frequency == pytest.approx(1 / period, rel=0.05)
        assert fit.amplitude == pytest.approx(amplitude, rel=0.05)
    assert fit.rms_px < 0.03 * amplitude
    later = fit.delayed(7)
    np.testing.assert_allclose(later.predict(20), fit.predict(13), atol=1e-9)


def test_v_is_not_fitted_but_follows():
    """Noise in v alone changes neither shift nor frequency nor amplitude."""
    t = np.arange(60)
    path = 100 * shape(t / 45 + 0.3) + [400, 100]
    noisy = path.copy()
    noisy[:, 1] += np.random.default_rng(0).normal(0, 10, len(t))
    one, two = (fit_template(TEMPLATE, x, facing=1, fps=FPS) for x in (path, noisy))
    assert (one.shift, one.frequency, one.amplitude) == (two.shift, two.frequency, two.amplitude)
    np.testing.assert_allclose(one.predict(t)[:, 1], path[:, 1], atol=4)


def test_too_few_frames_or_no_movement_give_no_fit():
    path = 100 * shape(np.arange(60) / 45)
    gone = path.copy()
    gone[45:50] = np.nan  # up to 5 frames are bridged
    assert fit_template(TEMPLATE, gone, facing=1, fps=FPS) is not None
    gone[:44] = np.nan
    assert fit_template(TEMPLATE, gone, facing=1, fps=FPS) is None
    assert fit_template(TEMPLATE, np.full((60, 2), np.nan), facing=1, fps=FPS) is None
    assert fit_template(TEMPLATE, np.ones((60, 2)), facing=1, fps=FPS) is None
    assert fit_template(TEMPLATE, path[:19], facing=1, fps=FPS, least_frames=20) is None


def test_a_slow_recording_limits_the_cutoff():
    """30 Hz is above half of 50 frames per second; the filter would refuse it."""
    path = 100 * shape(np.arange(60) / 9.0)
    fit = fit_template(TEMPLATE, path, facing=1, fps=50.0, least_frames=8)
    assert fit.frequency == pytest.approx(1 / 9, rel=0.1)


def test_a_template_is_written_and_read_again(tmp_path):
    template = StrideTemplate({"front": TEMPLATE, "hind": KindTemplate(-shape(SHARE), 0.3, 4)})
    path = template.save(tmp_path / "t.json")
    again = load_template(path)
    for kind in ("front", "hind"):
        np.testing.assert_allclose(again.kinds[kind].uv, template.kinds[kind].uv, atol=1e-5)
        assert again.kinds[kind].n_strides == template.kinds[kind].n_strides
        assert again.kinds[kind].period_s == pytest.approx(template.kinds[kind].period_s)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{", "not a stride template; make one with"),
        ('{"front": 1}', "not a stride template"),
        ('{"format": "pawnb stride template 1", "front": {}}', "a damaged stride template"),
    ],
)
def test_bad_files_are_refused(tmp_path, text, message):
    (tmp_path / "t.json").write_text(text)
    with pytest.raises(InputError, match=message):
        load_template(tmp_path / "t.json")
    with pytest.raises(InputError, match=r"absent\.json: no such file .*a stride template"):
        load_template(tmp_path / "absent.json")


def test_the_template_of_the_package_walks_as_animals_do():
    """A paw is lifted while it swings forwards, and swings faster than it is drawn back."""
    for own in load_template().kinds.values():
        u, v = own.uv.T
        swing = np.diff(u, append=u[0]) > 0
        assert 0.15 < swing.mean() < 0.5
        assert v[swing].mean() < v[~swing].mean()
        assert np.ptp(u) == pytest.approx(1.0, abs=0.1)
        assert own.n_strides >= 10
