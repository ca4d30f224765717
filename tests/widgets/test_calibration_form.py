"""The form that calibrates a trial: the unit that is asked for, and pictures that do not fit."""

import av
import numpy as np
import pandas as pd
import pytest
import small_trial as scene

import pawnb
from pawnb.errors import InputError
from pawnb.widgets.calibration_form import CalibrationForm
from pawnb.widgets.trial_form import TrialForm
from pawnb.workflow.workbench.states import state_of


@pytest.fixture
def bare(tmp_path):
    """Two films of the small trial without any description or calibration."""
    scene.write_trial(tmp_path)
    for name in ("trial.toml", "DLTcoefs.csv", "cam3.avi"):
        (tmp_path / name).unlink()
    return tmp_path


def test_a_unit_is_not_lost_where_the_views_are_calibrated_later(bare):
    form = TrialForm([bare / "cam1.avi", bare / "cam2.avi"])
    form.fps.value, form.unit.value, form.belt.value = "250", "cm", "30"
    assert form.write() is not None
    form.close()
    trial = pawnb.load_trial(bare)
    assert trial.calibration.unit == "cm"
    assert "calibrated" not in state_of(bare).done  # a unit alone is no calibration
    asked = CalibrationForm(trial)
    assert asked.unit.value == "cm"
    asked.close()


def calibrated_by_points(bare, said=None):
    """Click eight known corners in both films, and use the calibration."""
    xyz = np.array([[x, y, z] for x in (10, 60) for y in (0, 20) for z in (0, 15)], float)
    known = pd.DataFrame(xyz, columns=list("xyz"))
    known.insert(0, "point", [f"p{k}" for k in range(8)])
    known.to_csv(bare / "known.csv", index=False)
    asked = CalibrationForm(pawnb.load_trial(bare), done=None if said is None else said.append)
    asked.way.value, asked.file.value = "points", "known.csv"
    asked.begin()
    for view, k in (("cam1", 0), ("cam2", 1)):
        coefs = scene.COEFS[:, k]
        for point, place in zip(known["point"], xyz, strict=True):
            u, v = coefs[:3] @ place + coefs[3], coefs[4:7] @ place + coefs[7]
            asked.digitiser.edit(
                "moved", {"frame": 0, "view": view, "point": point, "u": u, "v": v}
            )
    return asked


def test_v_of_the_coefficients_before_is_not_said_of_the_new_ones(bare):
    """v was counted upwards in a DLTdv file; what is clicked here counts downwards."""
    form = TrialForm([bare / "cam1.avi", bare / "cam2.avi"])
    form.fps.value = "250"
    form.write()
    form.close()
    file = bare / "trial.toml"
    old = '\n[calibration]\ndlt = "old.csv"\nv = "up"\nforward = [0, 1, 0]\nunit = "mm"\n'
    text = file.read_text()
    file.write_text(text.split("[calibration]")[0] + old)
    said = []
    asked = calibrated_by_points(bare, said)
    asked.use()
    asked.close()
    calibration = pawnb.load_trial(bare).calibration
    assert calibration.v == "down"
    assert calibration.forward == (0.0, 1.0, 0.0)
    assert said == ["calibrated."]


def test_what_is_still_being_found_is_not_used(bare):
    form = TrialForm([bare / "cam1.avi", bare / "cam2.avi"])
    form.fps.value = "250"
    form.write()
    form.close()
    asked = calibrated_by_points(bare)
    asked.digitiser._doing = "Calibrating"
    with pytest.raises(InputError, match="Calibrating; wait for its end, then press again"):
        asked.use()
    asked.digitiser._doing = ""
    asked.close()


def test_pictures_of_another_size_than_the_film_do_not_calibrate_it(bare):
    form = TrialForm([bare / "cam1.avi", bare / "cam2.avi"])
    form.fps.value = "250"
    form.write()
    form.close()
    with av.open(str(bare / "large.avi"), "w") as file:
        stream = file.add_stream("mjpeg", rate=25)
        stream.width, stream.height, stream.pix_fmt = 1280, 720, "yuvj420p"
        blank = np.full((720, 1280, 3), 90, np.uint8)
        file.mux(stream.encode(av.VideoFrame.from_ndarray(blank, "rgb24")))
        file.mux(stream.encode())
    xyz = np.array([[x, y, z] for x in (10, 60) for y in (0, 20) for z in (0, 15)], float)
    known = pd.DataFrame(xyz, columns=list("xyz"))
    known.insert(0, "point", [f"p{k}" for k in range(8)])
    known.to_csv(bare / "known.csv", index=False)
    asked = CalibrationForm(pawnb.load_trial(bare))
    asked.way.value, asked.file.value = "points", "known.csv"
    for film in asked.films.values():
        film.value = "large.avi"
    asked.begin()
    for view, k in (("cam1", 0), ("cam2", 1)):
        coefs = scene.COEFS[:, k]
        for point, place in zip(known["point"], xyz, strict=True):
            u, v = 2 * (coefs[:3] @ place + coefs[3]), 2 * (coefs[4:7] @ place + coefs[7])
            asked.digitiser.edit(
                "moved", {"frame": 0, "view": view, "point": point, "u": u, "v": v}
            )
    with pytest.raises(InputError, match="of 1280 x 720 px, and its film has 640 x 360"):
        asked.use()
    assert pawnb.load_trial(bare).calibration is None
    asked.close()


def test_a_wand_in_the_trials_own_films_is_clicked_at_one_instant(bare):
    """Films that were not started together are shown as the trial aligns them."""
    form = TrialForm([bare / "cam1.avi", bare / "cam2.avi"])
    form.fps.value = "250"
    for row, frame in zip(form._rows, "74", strict=True):
        row._flash.field.value = frame
    form.write()
    form.close()
    asked = CalibrationForm(pawnb.load_trial(bare))
    asked.way.value, asked.length.value = "wand", "10"
    asked.begin()
    views = asked.digitiser._own_views
    numbers = []
    for shown in views.frame(2).values():  # each picture carries its number as a bar code
        row = shown.image()[scene.SQUARE // 2, :, 0]
        bits = row[scene.SQUARE // 2 :: scene.SQUARE][: scene.BITS] > 128
        numbers.append(int(np.dot(bits, 1 << np.arange(scene.BITS))))
    assert numbers == [5, 2]
    asked.way.value, asked.squares.value, asked.side.value = "board", "8 x 6", "5"
    with pytest.raises(InputError, match="were not started together"):
        asked.begin()
    asked.close()
