"""The folder of figures: everything that the tables allow, and a word on what they do not."""

from __future__ import annotations

import dataclasses
import json

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest
from fontTools.subset import Options
from matplotlib.figure import Figure
from PIL import Image

from pawnb import figures
from pawnb.errors import InputError
from pawnb.figures.panels import apart_from_pyplot, new_axes
from pawnb.gait import analyse_events
from pawnb.workflow.gait.drawing import save_figures
from pawnb.workflow.gait.drawing.drawings import gait_drawings
from pawnb.workflow.gait.drawing.save_figures import save_figure, save_gait_figures

mpl.use("Agg")


@pytest.fixture
def only_png(monkeypatch):
    """Save one format: writing three takes three times as long and shows no more."""
    monkeypatch.setattr(save_figures, "FORMATS", ("png",))


def events(legs=("L1", "R1"), trials=("t1",)):
    """A foot lands every 0.2 s and lifts 0.12 s later; right legs half a stride later."""
    return pd.DataFrame(
        [
            {"animal": "a", "trial": trial, "leg": leg, "event": event,
             "time_s": 0.2 * k + late + 0.1 * leg.startswith("R")}
            for trial in trials
            for leg in legs
            for k in range(5)
            for event, late in (("TD", 0.0), ("LO", 0.12))
        ]
    )  # fmt: skip


def drawn(files):
    return sorted({path.stem for path in files if path.suffix == ".png"})


@pytest.mark.slow
def test_two_legs_scored_by_hand_give_what_they_can(tmp_path, only_png):
    files = save_gait_figures(
        gait_drawings(analyse_events(events())), tmp_path, record={"step": "gait"}
    )
    assert drawn(files) == [
        "gait_diagram_a_t1", "phase_histogram", "phase_rose",
        "stepping_pattern", "summary_a", "support_shares",
    ]  # fmt: skip
    absent = pd.read_csv(tmp_path / "not_drawn.csv").set_index("figure")["why"]
    assert absent["phase_speed"].startswith("phase against speed: no stride has a speed")
    assert "against_speed" in absent.index
    assert not {"stride_average_fore_aft_position", "phase_plane"} & set(absent.index)
    assert sorted(tmp_path.iterdir()) == sorted(set(files))


@pytest.mark.slow
def test_one_leg_is_no_error(tmp_path, only_png):
    files = save_gait_figures(gait_drawings(analyse_events(events(("L1",)))), tmp_path, record={})
    assert "gait_diagram_a_t1" in drawn(files)
    absent = pd.read_csv(tmp_path / "not_drawn.csv")["figure"].tolist()
    assert {"phase_rose", "phase_histogram", "phase_speed"} <= set(absent)


@pytest.mark.slow
def test_a_style_that_was_set_is_in_the_recipe(tmp_path, only_png):
    tables = analyse_events(events())
    try:
        figures.set_style(column_mm=60, dpi=100)
        save_gait_figures(gait_drawings(tables), tmp_path, record={"step": "gait"}, which="main")
    finally:
        figures.set_style()
    with Image.open(tmp_path / "gait_diagram_a_t1.png") as picture:
        recipe = json.loads(picture.text["Description"])
        assert picture.width == pytest.approx(60 / 25.4 * 100, abs=1)
    assert recipe["figure"] == "gait_diagram"
    assert recipe["style"]["column_mm"] == 60
    save_gait_figures(gait_drawings(tables), tmp_path, record={"step": "gait"}, which="main")
    with Image.open(tmp_path / "gait_diagram_a_t1.png") as picture:
        assert "style" not in json.loads(picture.text["Description"])


@pytest.mark.slow
def test_main_and_none(tmp_path, only_png):
    tables = analyse_events(events(trials=("t1", "t2")))
    files = save_gait_figures(gait_drawings(tables), tmp_path, record={}, which="main")
    assert drawn(files) == ["gait_diagram_a_t1", "gait_diagram_a_t2", "phase_rose"]
    assert save_gait_figures(gait_drawings(tables), tmp_path / "no", record={}, which="none") == []
    with pytest.raises(InputError, match=r"^figures is 'few'; expected 'all', 'main' or 'none'"):
        save_gait_figures(gait_drawings(tables), tmp_path, record={}, which="few")


@pytest.mark.slow
def test_names_of_trials_and_animals_never_lead_out_of_the_folder(tmp_path, only_png):
    """Two trials whose names differ in signs only that no file name has."""
    table = events(trials=("../../x", "..-..-x")).assign(animal="/a")
    folder = tmp_path / "a" / "b" / "c" / "figures"
    files = save_gait_figures(gait_drawings(analyse_events(table)), folder, record={}, which="main")
    assert set(tmp_path.rglob("*.*")) == set(files)
    diagrams = sorted(path.name for path in files if path.name.startswith("gait_diagram"))
    assert diagrams == [
        "gait_diagram_-a_------x-2.csv", "gait_diagram_-a_------x-2.png",
        "gait_diagram_-a_------x.csv", "gait_diagram_-a_------x.png",
    ]  # fmt: skip


@pytest.mark.slow
def test_a_notebook_neither_draws_nor_closes_a_figure_that_is_being_saved(tmp_path, only_png):
    """The workbench draws off the thread that hears the browser.

    After each message of a widget IPython shows and closes every figure that pyplot knows
    (matplotlib_inline.backend_inline.flush_figures): one that was being saved came out half empty.
    And a figure of the person's own stays open.
    """
    own = plt.figure()
    before = plt.get_fignums()  # other tests of this process may have left some open
    known = []
    legs = ("FR", "HR")

    def spied(drawing):
        def draw():
            drawn = drawing.draw()
            known.append(plt.get_fignums())
            return drawn

        return dataclasses.replace(drawing, draw=draw)

    drawings = [spied(one) for one in gait_drawings(analyse_events(events(legs)))]
    save_gait_figures(drawings, tmp_path, record={"step": "gait"})
    assert (tmp_path / "not_drawn.csv").exists()
    assert set(map(tuple, known)) == {tuple(before)}
    assert plt.get_fignums() == before
    plt.close(own)


@pytest.mark.slow
def test_each_format_is_drawn_once_and_as_matplotlib_saves_it(tmp_path, monkeypatch):
    """Each was drawn twice: matplotlib lays out again wherever there is any engine of layout."""
    drawn, draw, dropped = [], Figure.draw, list(Options._drop_tables_default)
    with figures.style(), apart_from_pyplot():
        figure, ax = new_axes(figsize=(2.0, 2.0))
        ax.plot([0.0, 1.0], [0.0, 1.0])
        ax.set_ylabel("Duty factor")
        monkeypatch.setattr(Figure, "draw", lambda *own: drawn.append(1) or draw(*own))
        files = save_figure(ax, tmp_path / "own", record={"step": "gait"})
        monkeypatch.undo()
        # once to lay it out
        assert len(drawn) == 1 + len(files)
        figure.savefig(tmp_path / "usual.png", dpi=300.0)
        figure.savefig(tmp_path / "usual.pdf")
    own, usual = (np.asarray(Image.open(tmp_path / f"{name}.png")) for name in ("own", "usual"))
    assert np.array_equal(own, usual)
    # a font without its tables of layout is smaller
    assert (tmp_path / "own.pdf").stat().st_size < (tmp_path / "usual.pdf").stat().st_size
    assert Options._drop_tables_default == dropped
