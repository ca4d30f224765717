"""Forms that are filled in by half are so again after the kernel has ended."""

import json
import shutil

import pytest
import small_trial as scene

from pawnb.trial import load_trial
from pawnb.widgets.calibration_form import CalibrationForm
from pawnb.widgets.trial_form import TrialForm


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    return scene.write_trial(tmp_path_factory.mktemp("small") / "trial")


def test_what_was_typed_and_dragged_for_a_trial_is_there_again_until_it_is_made(small, tmp_path):
    video = shutil.copy(small.parent / "cam1.avi", tmp_path)
    form = TrialForm([video])
    draft = tmp_path / ".trial-draft.json"
    assert not draft.exists()  # who has typed nothing leaves nothing
    form.fps.value, form.animal.value, form.points.value = "250", "other", "<b>x, FR"
    form._canvas.edit("moved", {"view": "cam1", "point": "left top", "u": 20.0, "v": 10.0})
    form._add(form.made.views[0])
    form._rows[1].name.value = "below"
    form._rows[1].mirror.value = True
    form.close()
    again = TrialForm([video])
    assert (again.fps.value, again.animal.value, again.points.value) == ("250", "other", "<b>x, FR")
    first, second = again.made.views
    assert first.crop[:2] == (20, 10)
    assert (second.name, second.mirror) == ("below", True)
    again._remove(second)
    again.px_per_unit.value = "2"
    assert again.write() is not None
    assert not draft.exists()
    again.close()


OF_ANOTHER = (
    '{"more": [{"video": "x", "name": 1, "mirror": 0, "points": [], "crop": [3, 2, 1, 0]}]}'
)
WRONG_FIELDS = '{"fields": {"fps": 3, "animal": "gone"}, "more": 1}'


@pytest.mark.parametrize("text", ["[1", "[1]", WRONG_FIELDS, OF_ANOTHER])
def test_a_draft_that_is_none_is_left_out(small, tmp_path, text):
    video = shutil.copy(small.parent / "cam1.avi", tmp_path)
    (tmp_path / ".trial-draft.json").write_text(text)
    form = TrialForm([video])
    assert (form.fps.value, [view.name for view in form.made.views]) == ("", ["cam1"])
    form.close()


def test_what_was_typed_to_calibrate_is_there_again(small, tmp_path):
    trial = load_trial(shutil.copytree(small.parent, tmp_path / "trial") / "trial.toml")
    form = CalibrationForm(trial)
    form.way.value, form.length.value = "wand", "12.5"
    form.close()
    draft = trial.folder / ".calibration-draft.json"
    assert json.loads(draft.read_text())["fields"]["length"] == "12.5"
    again = CalibrationForm(trial)
    assert (again.way.value, again.length.value) == ("wand", "12.5")
    assert again.length.layout.display is None
    again.close()
