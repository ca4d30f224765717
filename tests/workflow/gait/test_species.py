"""A study's animals among other species: the law of Pullar (2009), section 4.2.1, and units."""

from __future__ import annotations

import json

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest

from pawnb.errors import InputError
from pawnb.workflow.gait.run import run_gait
from pawnb.workflow.gait.species import Species, species_drawings
from pawnb.workflow.gait.study import read_study

mpl.use("Agg")
CARAPACE_CM = np.array([0.1, 0.2, 0.4, 0.9, 2.0])


@pytest.fixture(autouse=True)
def _close():
    yield
    plt.close("all")


def spiders(path, *, sizes=CARAPACE_CM, size="carapace_cm", speed="speed_cm_s", share=1.0):
    """Species that follow the law of the thesis exactly: 58.908 times length to the 1.094."""
    groups = ["Lycosidae", "Sparassidae", "Lycosidae", "Sparassidae", "Lycosidae"]
    table = pd.DataFrame(
        {"name": [f"species {k}" for k in range(5)], "group": groups,
         size: sizes, speed: share * 58.908 * CARAPACE_CM**1.094}
    )  # fmt: skip
    table.to_csv(path, index=False)
    return path


def strides():
    """Two animals, two trials each; means of 300 and 360 mm/s, the fastest trial 400."""
    rows = [("a", "t1", 250.0), ("a", "t1", 350.0), ("a", "t2", 300.0), ("b", "t1", 320.0),
            ("b", "t2", 400.0)]  # fmt: skip
    return pd.DataFrame(rows, columns=["animal", "trial", "speed"])


FIELDS = {
    (animal, trial): {"carapace_mm": carapace, "mass_g": mass}
    for animal, carapace, mass in (("a", 9.0, 0.8), ("b", 11.0, 1.2))
    for trial in ("t1", "t2")
}


def drawn(path, **more):
    (drawing,) = species_drawings(
        strides(), FIELDS,
        [Species(path=path, name="Dolomedes aquaticus", group="Lycosidae", **more)], unit="mm",
    )  # fmt: skip
    return drawing, *drawing.draw()


def test_own_animals_are_one_point_beside_the_law_of_the_others(tmp_path):
    drawing, table, ax = drawn(spiders(tmp_path / "spiders.csv"))
    assert drawing.name == "species_spiders"
    own = table[table["own"].astype(bool) & (table["row"] == "point")].iloc[0]
    assert (own["x"], own["y"]) == pytest.approx((1.0, 33.0))  # 10 mm, 330 mm/s
    law = table[table["line"] == "reference"].iloc[0]
    assert (law["a"], law["b"]) == pytest.approx((58.908, 1.094), rel=1e-6)
    # the thesis: a carapace for which it predicts 56.206 cm/s
    assert law["a"] * 0.958 ** law["b"] == pytest.approx(56.206, rel=2e-3)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("Carapace (cm)", "Speed (cm/s)")
    assert set(table["line"].dropna()) == {"reference", "with own"}


def test_maximal_speeds_and_masses_in_other_units_and_a_group_left_out(tmp_path):
    path = spiders(
        tmp_path / "animals.csv", size="mass_kg", speed="max_speed_m_s", share=0.01,
    )  # fmt: skip
    more = pd.DataFrame({"name": ["x", "y"], "group": "other", "mass_kg": [3.0, 5.0],
                         "max_speed_m_s": [1.0, 1.1]})  # fmt: skip
    pd.concat([pd.read_csv(path), more]).to_csv(path, index=False)
    _, table, ax = drawn(path, without=("other",))
    own = table[table["own"].astype(bool) & (table["row"] == "point")].iloc[0]
    assert (own["x"], own["y"]) == pytest.approx((0.001, 0.4))  # 1 g, the fastest trial
    assert table[table["line"] == "without other"].iloc[0]["b"] == pytest.approx(1.094)
    assert ax.get_ylabel() == "Maximal speed (m/s)"


def test_what_lacks_is_one_sentence(tmp_path):
    path = spiders(tmp_path / "spiders.csv")
    one = [Species(path=path, name="me", group="g")]
    (drawing,) = species_drawings(strides(), FIELDS, one, unit="px")
    with pytest.raises(InputError, match="speeds are in px a second"):
        drawing.draw()
    (drawing,) = species_drawings(strides(), {**FIELDS, ("b", "t1"): {}, ("b", "t2"): {}}, one,
                                  unit="mm")  # fmt: skip
    with pytest.raises(InputError, match=r"no carapace with a unit \(such as carapace_cm\) of b"):
        drawing.draw()


STUDY = """
[[species]]
file = "spiders.csv"
name = "me"
group = "Lycosidae"
without = ["Sparassidae"]
[[trials]]
file = "e.csv"
animal = "a"
fps = 200.0
"""


def study(tmp_path, text=STUDY):
    spiders(tmp_path / "spiders.csv")
    rows = [(leg, event, 0.2 * k + late + 0.1 * (leg == "FL"))
            for leg in ("FR", "FL") for k in range(5)
            for event, late in (("TD", 0.0), ("LO", 0.12))]  # fmt: skip
    pd.DataFrame(rows, columns=["leg", "event", "time_s"]).to_csv(tmp_path / "e.csv", index=False)
    (tmp_path / "study.toml").write_text(text)
    return tmp_path / "study.toml"


def test_a_study_names_its_species_and_records_the_file(tmp_path):
    path = study(tmp_path)
    (one,) = read_study(path).species
    assert (one.path, one.name, one.without) == (tmp_path / "spiders.csv", "me", ("Sparassidae",))
    run = run_gait(path, figures="none")
    step = json.loads((run.out / "provenance.json").read_text())["steps"][0]
    assert any(label.endswith("spiders.csv") for label in step["inputs"])


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [('name = "me"', "", r"\[\[species\]\] is .*; expected file, name and group"),
     ('without = ["Sparassidae"]', 'withuot = ["x"]', r"\[\[species\]\] is "),
     ('["Sparassidae"]', "3", "without is 3; expected groups"),
     ("spiders.csv", "none.csv", "none.csv: no such file"),
     ('file = "spiders.csv"', 'file = "e.csv"', "columns are leg, event, time_s; expected name")],
)  # fmt: skip
def test_what_is_wrong_with_species_is_one_sentence(tmp_path, old, new, said):
    with pytest.raises(InputError, match=said):
        read_study(study(tmp_path, STUDY.replace(old, new, 1)))
