"""The scale of a view in trial.toml: written beside everything else that stands there."""

import pytest

from pawnb.errors import InputError
from pawnb.trial import load_trial
from pawnb.workflow.calibration.scale import write_scale

HEAD = (
    '[trial]\nkind = "pose"\nfps = 125.0  # as filmed\n\n[[views]]\nname = "top"\nvideo = "a.avi"\n'
)
START = '[start]\npose = "p.csv"\n'


def written(tmp_path, calibration, value=2.5):
    path = tmp_path / "trial.toml"
    path.write_text(HEAD + calibration)
    new = write_scale(load_trial(path), value)
    assert load_trial(path) == new
    return path.read_text()


def test_the_scale_is_changed_and_comments_stay(tmp_path):
    text = '\n[calibration]  # by hand\npx_per_unit = 4.84 # old\nunit = "cm"\n\n' + START
    assert written(tmp_path, text) == HEAD + text.replace("4.84", "2.5")


def test_a_scale_is_added_to_a_calibration_without_one(tmp_path):
    new = written(tmp_path, '\n[calibration]\nunit = "cm"\n' + START)
    assert new == HEAD + '\n[calibration]\npx_per_unit = 2.5\nunit = "cm"\n' + START


def test_a_calibration_is_added_where_there_is_none(tmp_path):
    new = written(tmp_path, "", value=12.3456789)
    assert new == HEAD + '\n[calibration]\npx_per_unit = 12.3457\nunit = "mm"\n'


def test_what_cannot_be_changed_is_told_and_left(tmp_path):
    path = tmp_path / "trial.toml"
    path.write_text("calibration = { px_per_unit = 3.0 }\n" + HEAD)
    before = path.read_text()
    with pytest.raises(InputError, match=r"px_per_unit = 2[.]5 there yourself"):
        write_scale(load_trial(path), 2.5)
    assert path.read_text() == before
    path.write_text(HEAD + '[calibration]\ndlt = "DLTcoefs.csv"\n')
    with pytest.raises(InputError, match=r"calibrated by DLTcoefs[.]csv"):
        write_scale(load_trial(path), 2.5)
    path.write_text(HEAD)
    trial = load_trial(path)
    path.unlink()
    with pytest.raises(InputError, match="no such file"):
        write_scale(trial, 2.5)


def test_a_scale_that_another_window_has_measured_is_not_written_over(tmp_path):
    path = tmp_path / "trial.toml"
    path.write_text(HEAD + "[calibration]\npx_per_unit = 4.0\n")
    here, there = load_trial(path), load_trial(path)
    write_scale(there, 4.5)
    with pytest.raises(InputError) as raised:
        write_scale(here, 5.0)
    assert "px_per_unit is 4.5 there and was 4 when the trial was read" in str(raised.value)
    assert load_trial(path).calibration.px_per_unit == 4.5
    write_scale(load_trial(path), 5.0)
    assert load_trial(path).calibration.px_per_unit == 5.0
