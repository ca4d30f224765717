"""A study of spiders without pictures: its laws, its tracks, its truth."""

from __future__ import annotations

import numpy as np
import pytest

from pawnb import gait
from pawnb.errors import InputError
from pawnb.gait.regression.scaling import EXPECTED_EXPONENTS
from pawnb.synthetic.spider_study import simulate_spider_study, true_exponents

pytestmark = pytest.mark.slow  # scenes are rendered and tracked


@pytest.fixture(scope="module")
def study():
    return simulate_spider_study(animals=2, trials=2, seed=4)


def test_exponents_on_mass_are_those_of_heglund():
    # Pullar 2009, Table 4.4: speed 0.24, stride frequency -0.14, stride length 0.38
    printed = {
        row.parameter: row.exponent
        for row in EXPECTED_EXPONENTS
        if row.source.startswith("Heglund")
    }
    found = true_exponents()
    assert printed == {"speed": 0.24, "frequency_hz": -0.14, "stride_length": 0.38}
    for name, exponent in printed.items():
        assert found[name, "mass"] == pytest.approx(exponent, abs=0.005)
    # a length is as the cube root of mass; speed is frequency times stride length
    assert found["speed", "body_length"] == pytest.approx(3 * 0.24)
    product = found["frequency_hz", "mass"] + found["stride_length", "mass"]
    assert product == pytest.approx(found["speed", "mass"])


def test_animals_and_runs_differ_as_said(study):
    lengths = study.animals["body_length_mm"].to_numpy()
    assert max(lengths) / min(lengths) == pytest.approx(1.0 / 0.64)
    mass = study.animals["mass_g"].to_numpy()
    np.testing.assert_allclose(mass / lengths**3, mass[0] / lengths[0] ** 3)
    speed = study.truth("strides").groupby(["animal", "trial"])["speed"].mean()
    for _, own in speed.groupby("animal"):
        # 8 to 18 % on either side of the animal's own; the speed waves by 7 % within a run
        assert 0.05 < np.ptp(np.log(own)) < 0.5


def test_stride_length_is_as_size_and_speed(study):
    """The stance travel is size (v / v0)^0.2; a stride is that over the duty factor of contact."""
    for run in study.runs:
        motion, size = run.recording.motion, run.recording.individual.size
        speed = float(np.hypot(*motion.body.velocity_mm_s))
        length = speed / motion.frequency_hz
        expected = size * 14.0 * (speed / 155.0) ** 0.2 / motion.duty_factor
        assert length == pytest.approx(expected, rel=0.002)
        assert run.strides["stride_length"].mean() == pytest.approx(expected, rel=0.1)


def test_tracks_without_noise_are_where_the_legs_are(study):
    run = study.runs[0]
    recording = run.recording
    tracks = run.tracks(noise_px=0.0, angle_noise_deg=0.0)
    names = [leg.name for leg in recording.individual.animal.legs]
    tips = recording.middle(recording.joints_px)[recording.whole][:, :, -1]
    image = tracks["image_position"].isel(view=0, individual=0).sel(keypoint=names)
    found = image.transpose("time", "keypoint", "image_space").to_numpy()
    np.testing.assert_allclose(found, tips, atol=1e-6)
    place = tracks["position"].isel(individual=0).sel(keypoint=names)
    place = place.transpose("time", "keypoint", "space").to_numpy()
    np.testing.assert_allclose(place * recording.scene.px_per_mm, tips, atol=1e-6)
    # the leg angle of the gait analysis is that of the continuous motion
    angles = gait.leg_angles(tracks)
    own = angles[angles["leg"] == "L2"]
    true = recording.motion.leg_angle("L2", own["frame"].to_numpy() / run.trial.fps)
    np.testing.assert_allclose(own["leg_angle"], true, atol=0.01)


def test_noise_is_as_large_as_said(study):
    run = study.runs[0]
    still = run.tracks(noise_px=0.0, angle_noise_deg=0.0)
    noisy = run.tracks(noise_px=0.7, angle_noise_deg=2.0)
    away = (noisy["image_position"] - still["image_position"]).to_numpy()
    assert away.std() == pytest.approx(0.7, rel=0.03)
    scale = run.recording.scene.px_per_mm
    moved = (noisy["position"] - still["position"]).to_numpy()
    assert moved.std() == pytest.approx(0.7 / scale, rel=0.03)
    assert (noisy["joint_angle"] - still["joint_angle"]).to_numpy().std() == pytest.approx(
        2.0, rel=0.05
    )
    again, other = run.tracks(noise_px=0.7), run.tracks(noise_px=0.7, seed=1)
    assert again["position"].equals(run.tracks(noise_px=0.7)["position"])
    assert not again["position"].equals(other["position"])


def test_strides_are_found_again(study):
    """Independent of the truth's formulas: the gait analysis works on positions.

    A leg turns fast from stance to swing, so the extreme between two frames is found about 0.06
    frames towards the stance: stances of 13 frames come out 1 % short. Between frames angles are
    interpolated by straight lines, which cut the peaks: excursions come out up to 3 % short,
    and with swings of 5 frames 0.13 frames too long, angular velocities of swing up to 8 % low.
    """
    parts = [gait.analyse(run.tracks(noise_px=0.05), trial=run.trial) for run in study.runs]
    found, true = gait.pool(parts).strides, study.truth("strides")
    names = ["frequency_hz", "duty_factor", "speed", "stride_length", "swing_distance"]
    names += ["excursion_deg", "swing_velocity_deg_s", "stance_velocity_deg_s"]
    means = [table.groupby(["animal", "trial"])[names].mean() for table in (found, true)]
    for name, tolerance in zip(
        names, (0.01, 0.03, 0.02, 0.02, 0.03, 0.05, 0.09, 0.05), strict=True
    ):
        np.testing.assert_allclose(means[0][name], means[1][name], rtol=tolerance, err_msg=name)


def test_true_angles_name_leg_and_joint(study):
    angles = study.true_angles()
    run = study.runs[0]
    own = angles[(angles["trial"] == run.trial.name) & (angles["leg"] == "R3")]
    np.testing.assert_allclose(own.loc[own["joint"] == "TM", "angle_deg"], run.pose["R3_TM"])


def test_the_same_seed_is_the_same_study(study):
    again = simulate_spider_study(animals=2, trials=2, seed=4)
    assert again.truth("events").equals(study.truth("events"))
    assert again.animals.equals(study.animals)


def test_bad_input_is_told(study):
    with pytest.raises(InputError, match="0 animals with 2 runs; expected 1 or more"):
        simulate_spider_study(animals=0)
    with pytest.raises(InputError, match="noise is -1 px"):
        study.runs[0].tracks(noise_px=-1)
    with pytest.raises(InputError, match="truth of 'tables'"):
        study.truth("tables")
