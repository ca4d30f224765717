"""Gait diagram: the table by hand, and bars where the table says."""

from __future__ import annotations

import matplotlib as mpl
import matplotlib.pyplot as plt
import pandas as pd
import pytest
from matplotlib.colors import to_hex

from pawnb import load_tracks
from pawnb.errors import InputError
from pawnb.figures import build_gait_diagram_table, plot_gait_diagram
from pawnb.gait import analyse

mpl.use("Agg")


@pytest.fixture(autouse=True)
def _close():
    yield
    plt.close("all")


def events(**legs):
    return pd.DataFrame(
        [
            {"animal": "m", "trial": "t", "leg": leg, "event": e, "time_s": t}
            for leg, rows in legs.items()
            for e, t in rows
        ]
    )


TWO = {
    "FL": [("PEP", 0.3), ("AEP", 0.5), ("PEP", 0.8), ("AEP", 0.9)],
    "FR": [("AEP", 0.1), ("PEP", 0.4), ("AEP", 0.6), ("PEP", 1.0)],
}


def test_bars_by_hand():
    table = build_gait_diagram_table(events(**TWO))
    assert table.to_numpy().tolist() == [
        ["FR", 0.1, 0.4, "stance", ""],
        ["FR", 0.6, 1.0, "stance", ""],
        ["FL", 0.1, 0.3, "stance", "start"],
        ["FL", 0.5, 0.8, "stance", ""],
        ["FL", 0.9, 1.0, "stance", "end"],
    ]
    assert list(table.columns) == ["leg", "start_s", "end_s", "phase", "cut"]


def test_span_of_the_recording_opens_the_edges():
    table = build_gait_diagram_table(events(**TWO), span_s=(0.0, 1.2))
    fl = table[table["leg"] == "FL"]
    assert fl["start_s"].iloc[0] == 0.0
    assert fl["end_s"].iloc[-1] == 1.2
    assert table[table["leg"] == "FR"]["cut"].tolist() == ["", ""]


def test_a_missing_event_is_unknown_not_stance():
    table = build_gait_diagram_table(
        events(FR=[("AEP", 0.1), ("AEP", 0.5), ("PEP", 0.7), ("PEP", 1.0)])
    )
    assert table[["start_s", "end_s", "phase"]].to_numpy().tolist() == [
        [0.1, 0.5, "unknown"], [0.5, 0.7, "stance"], [0.7, 1.0, "unknown"],
    ]  # fmt: skip


def test_stance_that_was_not_tracked_is_unknown():
    dropped = pd.DataFrame(
        [("FR", 0.2, 0.3, "track"), ("FR", 0.7, 0.8, "position")],
        columns=["leg", "start_s", "end_s", "what"],
    )
    table = build_gait_diagram_table(events(**TWO), dropped=dropped)
    assert table["phase"].tolist() == ["unknown", "stance", "stance", "stance", "stance"]


@pytest.mark.parametrize("what", ["track", "pause"])
def test_swing_that_was_not_tracked_is_not_shown_as_a_foot_in_the_air(what):
    # FR swings from 0.4 to 0.6, FL from 0.3 to 0.5 and from 0.8 to 0.9
    gone = pd.DataFrame(
        [("FR", 0.45, 0.5, what), ("FL", 0.85, 0.87, what)],
        columns=["leg", "start_s", "end_s", "what"],
    )
    table = build_gait_diagram_table(events(**TWO), dropped=gone)
    unknown = table[table["phase"] == "unknown"][["leg", "start_s", "end_s"]]
    assert unknown.to_numpy().tolist() == [["FR", 0.4, 0.6], ["FL", 0.8, 0.9]]
    assert (table["phase"] == "stance").sum() == len(build_gait_diagram_table(events(**TWO)))


def test_a_swing_cut_by_the_edge_of_the_recording_is_unknown_where_it_was_not_tracked():
    gone = pd.DataFrame(
        [("", 0.0, 0.05, "frames"), ("", 1.1, 1.2, "frames")],
        columns=["leg", "start_s", "end_s", "what"],
    )
    table = build_gait_diagram_table(events(**TWO), dropped=gone, span_s=(0.0, 1.2))
    unknown = table[table["phase"] == "unknown"][["leg", "start_s", "end_s", "cut"]]
    assert unknown.to_numpy().tolist() == [
        ["FR", 0.0, 0.1, ""], ["FR", 1.0, 1.2, ""], ["FL", 0.0, 0.3, ""], ["FL", 0.9, 1.2, ""],
    ]  # fmt: skip


def test_what_was_dropped_in_other_trials_hides_nothing():
    gone = pd.DataFrame(
        [("m", "other", "FR", 0.2, 0.3, "track"), ("m", "t", "FL", 0.6, 0.7, "track")],
        columns=["animal", "trial", "leg", "start_s", "end_s", "what"],
    )
    table = build_gait_diagram_table(events(**TWO), dropped=gone)
    assert table.loc[table["phase"] == "unknown", "leg"].tolist() == ["FL"]


@pytest.mark.slow
def test_a_mouse_that_stands_has_no_feet_in_the_air(real_data):
    """Hatched, or in stance: no foot swings for seconds while a mouse grooms or rears."""
    file = real_data("mouse-openfield-dlc") / "raw_clip1DLC.csv"
    found = analyse(load_tracks(file, fps=60.0))
    table = build_gait_diagram_table(found.events, dropped=found.dropped)
    for _, own in table.groupby("leg"):
        swing_s = own["start_s"].to_numpy()[1:] - own["end_s"].to_numpy()[:-1]
        assert swing_s.max() < 1.0  # s; a swing of a mouse lasts a tenth of that


def test_contact_can_be_asked_for():
    both = events(FR=[*TWO["FR"], ("TD", 0.15), ("LO", 0.35)])
    assert len(build_gait_diagram_table(both)) == 2
    contact = build_gait_diagram_table(both, stance_from="TD")
    assert contact[["start_s", "end_s"]].to_numpy().tolist()[0] == [0.15, 0.35]


def test_bars_are_drawn_where_the_table_says():
    table = build_gait_diagram_table(events(**TWO))
    ax = plot_gait_diagram(table)
    bars = ax.patches
    assert len(bars) == len(table)
    rows = {"FR": 0, "FL": 1}
    for bar, row in zip(bars, table.itertuples(), strict=True):
        assert bar.get_x() == pytest.approx(row.start_s)
        assert bar.get_x() + bar.get_width() == pytest.approx(row.end_s)
        assert bar.get_y() + bar.get_height() / 2 == pytest.approx(rows[row.leg])
        assert (bar.get_alpha() or 1.0) < 1.0 or not row.cut
    assert to_hex(bars[0].get_facecolor()) != to_hex(bars[3].get_facecolor())
    assert [t.get_text() for t in ax.get_yticklabels()] == ["FR", "FL"]
    low, high = ax.get_ylim()
    assert low > high  # first leg on top
    assert ax.get_xlabel() == "Time (s)"
    assert ax.texts[0].get_text() == "pale: stance goes on beyond what is shown"
    assert ax.figure.get_size_inches()[0] * 25.4 == pytest.approx(85.0)


def test_unknown_bars_are_hatched_and_said():
    table = build_gait_diagram_table(events(FR=[("AEP", 0.1), ("AEP", 0.5), ("PEP", 0.7)]))
    ax = plot_gait_diagram(table)
    assert ax.patches[0].get_hatch() == "////"
    assert ax.texts[0].get_text() == "hatched: not known"


def test_given_axes_are_used():
    _, ax = plt.subplots()
    assert plot_gait_diagram(build_gait_diagram_table(events(**TWO)), ax=ax) is ax


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: build_gait_diagram_table(events(**TWO).iloc[:0]), r"^gait diagram: no events"),
        (lambda: build_gait_diagram_table(events(**TWO).drop(columns="leg")),
         r"^events: column 'leg' is missing"),
        (lambda: build_gait_diagram_table(events(**TWO).assign(trial=list("aabbccdd"))),
         r"^gait diagram: events of 4 trials; choose one, for instance events\[events\['trial'\]"),
        (lambda: plot_gait_diagram(build_gait_diagram_table(events(**TWO)).iloc[:0]),
         r"^gait diagram: the table has no bars\.$"),
    ],
)  # fmt: skip
def test_bad_input_is_refused(call, message):
    with pytest.raises(InputError, match=message):
        call()


def test_names_with_dollar_signs_are_drawn_as_they_are(tmp_path):
    # to matplotlib two of them enclose mathematics, which this is not
    name = r"$\frac$ leg"
    table = build_gait_diagram_table(events(**{name: [("TD", 0.0), ("LO", 0.12), ("TD", 0.2)]}))
    ax = plot_gait_diagram(table)
    ax.figure.savefig(tmp_path / "diagram.svg")
    assert name in (tmp_path / "diagram.svg").read_text()


def test_the_name_of_the_axis_is_whole_where_there_is_one_leg():
    ax = plot_gait_diagram(build_gait_diagram_table(events(FL=TWO["FL"])))
    ax.figure.canvas.draw()
    named = ax.yaxis.label.get_window_extent()
    assert named.y0 >= 0
    assert named.y1 <= ax.figure.bbox.height
