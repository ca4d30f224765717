"""The GaitExplorer: what its state does, and that pointer, buttons and plots go together."""

from __future__ import annotations

import dataclasses
import threading

import numpy as np
import pandas as pd
import pytest
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from pawnb import gait
from pawnb.errors import InputError
from pawnb.gait.events.event_edits import replay_event_edits
from pawnb.synthetic.spider_study import simulate_spider_study
from pawnb.widgets.gait_panels import GaitPanels
from pawnb.widgets.gait_session import GaitSession

FROM_IPYMPL = "ignore:Passing unrecognized arguments:DeprecationWarning"


def events_of(trial, period_s):
    """Two legs, six strides, stance 60 %; L1 is half a stride after R1."""
    rows = [
        {"animal": "m1", "trial": trial, "leg": leg, "event": event,
         "time_s": period_s * (lag + k + after)}
        for leg, lag in (("L1", 0.5), ("R1", 0.0))
        for k in range(7)
        for event, after in (("AEP", 0.0), ("PEP", 0.6))
    ]  # fmt: skip
    return pd.DataFrame(rows)


@pytest.fixture
def tables():
    return gait.analyse_events(pd.concat([events_of("t1", 0.2), events_of("t2", 0.3)]))


@pytest.fixture(scope="module")
def spider():
    run = simulate_spider_study(animals=1, trials=1, seed=3).runs[0]
    return gait.analyse(run.tracks(noise_px=0.2), trial=run.trial)


def test_a_stride_is_picked_by_its_leg_and_time(tables):
    session = GaitSession(tables)
    assert session.trials == (("m1", "t1"), ("m1", "t2"))
    assert session.pair == ("L1", "R1")
    assert session.pick("R1", 0.45) == ("R1", pytest.approx(0.4))
    assert session.picked()["period_s"] == pytest.approx(0.2)
    assert session.pick("R1", 9.0) is None
    session.show("m1", "t2")
    assert session.pick("L1", 0.5) == ("L1", pytest.approx(0.45))


def test_phases_of_the_picked_stride_are_those_of_either_leg(tables):
    session = GaitSession(tables)
    session.pick("R1", 0.45)
    assert session.picked_phases() == [pytest.approx(0.5)]
    session.pick("L1", 0.35)
    assert session.picked_phases() == [pytest.approx(0.5)]
    # R1's landing at 0.4 s moves: L1's at 0.3 s is then 0.1 s after 0.2 s in a stride of 0.22 s
    session.pick("R1", 0.45)
    session.pick_event(0.4, within_s=0.01)
    session.move_event(0.42)
    session.pick("L1", 0.35)
    assert session.picked_phases() == [pytest.approx(0.1 / 0.22)]


@pytest.mark.slow
def test_moving_deleting_excluding_and_undoing(tables, tmp_path):
    path = tmp_path / "event_edits.jsonl"
    session = GaitSession(tables, path)
    session.pick("R1", 0.45)
    assert session.pick_event(0.5, within_s=0.01) is None
    assert session.pick_event(0.525, within_s=0.01) == ("R1", "PEP", pytest.approx(0.52))
    session.move_event(0.5)
    assert session.picked()["duty_factor"] == pytest.approx(0.5)
    assert "PEP of R1 at 0.500 s" in session.text()
    assert session.text().startswith("1 correction; R1, stride 3: from 0.400 s")
    session.exclude_stride("turned")
    assert session.stride is None
    assert "excluded by hand: turned" in set(session.dropped["why"])
    session.undo()
    session.pick("R1", 0.45)
    session.pick_event(0.5, within_s=0.01)
    session.delete_event()
    assert session.stride is None  # without its PEP it is none
    for name in ("strides", "phases", "events"):
        replayed = getattr(replay_event_edits(tables, path), name)
        pd.testing.assert_frame_equal(replayed, getattr(session.tables, name))
    session.undo()
    session.undo()
    pd.testing.assert_frame_equal(session.tables.strides, tables.strides)
    session.redo()
    assert len(session.edits.active) == 1
    # the other trial was never touched
    second = session.tables.strides[session.tables.strides["trial"] == "t2"]
    np.testing.assert_allclose(second["period_s"], 0.3)


def test_legs_and_pairs_are_chosen(spider):
    session = GaitSession(spider)
    session.show_legs(["R2", "L1"])
    assert session.legs == ("L1", "R2")
    assert set(session.events["leg"]) == {"L1", "R2"}
    session.show_pair("L3", "L4")
    assert set(session.phases["leg"]) == {"L3"}
    assert session.signal().signal == "leg angle"
    assert session.shown_leg == "L3"
    session.pick("R2", float(session.strides.query("leg == 'R2'")["start_s"].iloc[0]) + 0.01)
    assert session.shown_leg == "R2"
    with pytest.raises(InputError, match="phase of L1 to R4 was not measured"):
        session.show_pair("L1", "R4")
    with pytest.raises(InputError, match="no leg 'X'"):
        session.show_legs(["X"])
    with pytest.raises(InputError, match="at least one leg"):
        session.show_legs([])


def test_what_is_picked_goes_with_the_signal_that_it_was_picked_in(spider, tables):
    session = GaitSession(spider)
    first = session.leg_events.iloc[3]
    picked = session.pick_event(first["time_s"], within_s=1e-6, kinds=[first["event"]])
    assert picked[0] == session.shown_leg == "L1"
    session.show_pair("L1", "R1")  # the same leg: it stays
    assert session.event == picked
    session.show_pair("L3", "L4")  # Delete would take away an event of L1 behind the signal of L3
    assert session.shown_leg == "L3"
    assert session.event is None
    # a place beside all events of one leg is none of another leg, or of another trial
    session.pick_event(first["time_s"] + 0.001, within_s=0.0)
    assert session.place_s is not None
    session.pick("R2", first["time_s"])
    assert session.place_s is None
    two = GaitSession(tables)
    two.pick_event(0.31, within_s=0.0)
    two.show("m1", "t2")
    assert two.place_s is None
    with pytest.raises(InputError, match="pick a place first"):
        two.add_event("AEP")


def test_what_undo_takes_back_is_said_as_it_may_be_of_another_trial(tables, tmp_path):
    session = GaitSession(tables, tmp_path / "event_edits.jsonl")
    session.pick("R1", 0.45)
    session.pick_event(0.52, within_s=0.01)
    session.move_event(0.5)
    session.show("m1", "t2")
    session.undo()
    assert session.text() == "0 corrections; taken back: moved PEP of R1 at 0.520 s (m1, t1)."
    session.redo()
    assert session.text() == "1 correction; made again: moved PEP of R1 at 0.520 s (m1, t1)."
    session.pick("R1", 0.4)
    assert "made again" not in session.text()
    assert "kept nowhere" not in session.text()


def test_corrections_that_no_file_keeps_say_so(tables):
    session = GaitSession(tables)
    assert "kept nowhere" not in session.text()  # nothing to lose yet
    session.pick("R1", 0.45)
    session.exclude_stride("turned")
    assert session.text().startswith("1 correction; kept nowhere, as no file was given: ")


def test_what_is_not_picked_cannot_be_corrected(tables):
    session = GaitSession(tables)
    with pytest.raises(InputError, match="pick a stride first"):
        session.exclude_stride("x")
    with pytest.raises(InputError, match="pick an event first"):
        session.move_event(0.3)
    with pytest.raises(InputError, match="no trial 't9'"):
        session.show("m1", "t9")


class Mouse:
    """What matplotlib tells of the pointer."""

    def __init__(self, ax, x, y=0.0):
        self.inaxes, self.xdata, self.ydata = ax, x, y
        self.x, self.y = ax.transData.transform((x, y))


def test_a_leg_has_one_colour_in_every_plot(tables):
    session = GaitSession(tables)
    panels = GaitPanels(Figure(), session)
    panels.draw()
    for leg in ("R1", "L1"):
        session.pick(leg, 0.45)
        panels.draw_leg()
        row = panels.rows.index(leg)
        bars = [bar for bar in panels.diagram.patches if abs(bar.get_y() + 0.35 - row) < 0.01]
        point = panels.strides.lines[0]
        assert to_hex(point.get_color()) == to_hex(bars[0].get_facecolor())


@pytest.mark.slow
@pytest.mark.filterwarnings(FROM_IPYMPL)
def test_pointer_and_buttons_reach_the_plots(spider):
    from pawnb.widgets.gait_explorer import GaitExplorer

    explorer = GaitExplorer(spider)
    session = explorer.session
    own = spider.strides[spider.strides["leg"] == "R2"].iloc[1]
    row = explorer._panels.rows.index("R2")
    explorer._on_press(Mouse(explorer._panels.diagram, own["start_s"] + 0.02, row + 0.2))
    assert session.stride == ("R2", own["start_s"])
    frame = explorer._panels.diagram.patches[-1]
    assert frame.get_x() == pytest.approx(own["start_s"])
    assert frame.get_width() == pytest.approx(own["period_s"])
    assert frame.get_y() == pytest.approx(row - 0.46)
    line = explorer._panels.signal.lines[0]
    signal = session.signal()
    assert signal.legs.index("R2") >= 0
    np.testing.assert_array_equal(line.get_ydata(), signal.samples[:, signal.legs.index("R2")])
    explorer._pair.value = ("R2", "R3")
    assert session.pair == ("R2", "R3")
    assert len(explorer._panels.rose.lines) == len(session.picked_phases()) == 1
    assert explorer._panels.rose.lines[0].get_xdata()[0] == pytest.approx(
        2 * np.pi * session.picked_phases()[0]
    )
    # drag the end of its stance by 8 ms
    pep = own["start_s"] + own["stance_s"]
    low, high = explorer._panels.signal.get_ylim()
    above, below = low + 0.8 * (high - low), low + 0.2 * (high - low)
    explorer._on_press(Mouse(explorer._panels.signal, pep + 0.001, below))
    assert session.event[1] == "LO"  # contact stands in the lower half
    explorer._on_press(Mouse(explorer._panels.signal, pep + 0.001, above))
    assert session.event[1] == "PEP"
    explorer._on_release(Mouse(explorer._panels.signal, pep + 0.009, above))
    found = session.picked()
    assert found["stance_s"] == pytest.approx(own["stance_s"] + 0.008)
    explorer._on_press(Mouse(explorer._panels.signal, pep + 0.008, above))
    explorer._on_release(Mouse(explorer._panels.signal, pep + 0.008, above))
    assert len(session.edits.active) == 1  # a click moves nothing
    explorer._exclude.click()
    assert "say why" in explorer._told.value
    explorer._reason.value = "stumbled"
    explorer._exclude.click()
    assert len(explorer.tables.strides) == len(spider.strides) - 1
    assert explorer._reason.value == ""
    assert not explorer._undo.disabled
    explorer._undo.click()
    explorer._undo.click()
    assert explorer._undo.disabled
    assert not explorer._redo.disabled
    pd.testing.assert_frame_equal(explorer.tables.strides, spider.strides)


@pytest.mark.slow
@pytest.mark.filterwarnings(FROM_IPYMPL)
def test_another_trial_offers_its_legs(tables):
    from pawnb.widgets.gait_explorer import GaitExplorer

    explorer = GaitExplorer(tables)
    explorer._trial.value = ("m1", "t2")
    assert explorer._panels.diagram.get_xlim()[1] == pytest.approx(0.3 * 7.1)
    assert explorer._panels.signal.get_ylabel() == "L1: events"
    explorer._legs["L1"].value = False
    assert explorer._panels.rows == ["R1"]
    explorer._legs["R1"].value = False
    assert explorer._told.value == "choose at least one leg."
    assert explorer._legs["R1"].value  # the last one stays


@pytest.mark.slow
@pytest.mark.filterwarnings(FROM_IPYMPL)
def test_a_stride_is_picked_among_the_points_and_its_window_stays(tables):
    from pawnb.widgets.gait_explorer import GaitExplorer

    explorer = GaitExplorer(tables)
    session, panels = explorer.session, explorer._panels
    explorer._span.value = (0.3, 0.9)
    # R1 lands at 0.4 s; 20 ms later its stride is 0.18 s and the one before it 0.22 s
    session.pick("R1", 0.45)
    session.pick_event(0.4, within_s=0.01)
    explorer._do(lambda: session.move_event(0.42))
    explorer._on_press(Mouse(panels.strides, 0.22, 0.12 / 0.22))
    assert session.stride == ("R1", pytest.approx(0.2))
    explorer._on_press(Mouse(panels.strides, 0.18, 0.10 / 0.18))
    assert session.stride == ("R1", pytest.approx(0.42))
    assert panels.strides.lines[-1].get_xdata() == pytest.approx([0.18])
    assert panels.diagram.get_xlim() == panels.signal.get_xlim() == (0.3, 0.9)
    explorer._trial.value = ("m1", "t2")
    assert panels.diagram.get_xlim() == pytest.approx((0.0, 0.3 * 7.1))


@pytest.mark.filterwarnings(FROM_IPYMPL)
def test_the_line_follows_the_pointer_and_goes_back_where_it_cannot_stay(tables):
    from pawnb.widgets.gait_explorer import GaitExplorer

    explorer = GaitExplorer(tables)
    session, panels = explorer.session, explorer._panels
    explorer._on_press(Mouse(panels.diagram, 0.45, panels.rows.index("R1")))
    assert explorer._delete.disabled
    assert not explorer._exclude.disabled
    explorer._on_press(Mouse(panels.signal, 0.521, 0.5))
    assert not explorer._delete.disabled
    explorer._on_move(Mouse(panels.signal, 0.571, 0.5))
    assert panels.event_line.get_xdata() == pytest.approx([0.57, 0.57])
    assert explorer._told.value == "PEP of R1 to 0.570 s"
    assert session.edits.active == ()
    # R1 lands again at 0.6 s: its lift-off cannot be later
    explorer._on_move(Mouse(panels.signal, 0.671, 0.5))
    explorer._on_release(Mouse(panels.signal, 0.671, 0.5))
    assert "expected a time between its neighbours, 0.4000 to 0.6000 s" in explorer._told.value
    assert panels.event_line.get_xdata() == pytest.approx([0.52, 0.52])
    assert session.edits.active == ()
    # let go outside of the plot: nothing has moved
    explorer._on_press(Mouse(panels.signal, 0.521, 0.5))
    explorer._on_move(Mouse(panels.signal, 0.551, 0.5))
    explorer._on_release(Mouse(panels.diagram, 0.551, 0.5))
    assert panels.event_line.get_xdata() == pytest.approx([0.52, 0.52])


@pytest.mark.filterwarnings(FROM_IPYMPL)
@pytest.mark.slow
def test_plots_are_not_shown_while_they_are_drawn_anew(tables, monkeypatch):
    """The canvas draws in another thread of the kernel than a change of the page's theme."""
    from pawnb.widgets.gait_explorer import GaitExplorer

    widget = GaitExplorer(tables)
    begun, may_end, order = threading.Event(), threading.Event(), []
    draw = widget._panels.draw

    def slow():
        begun.set()
        assert may_end.wait(30)
        draw()
        order.append("anew")

    monkeypatch.setattr(widget._panels, "draw", slow)
    theme = threading.Thread(target=setattr, args=(widget._around, "dark", True))
    theme.start()
    assert begun.wait(30)
    shown = threading.Thread(target=lambda: (widget._canvas.draw(), order.append("shown")))
    shown.start()
    shown.join(1.0)  # long enough to be drawn, were nothing to wait for
    may_end.set()
    theme.join(30)
    shown.join(30)
    assert order == ["anew", "shown"]
    widget.close()


def test_a_stride_that_does_not_count_says_why(tables):
    session = GaitSession(tables)
    session.pick("R1", 0.45)
    session.exclude_stride("stumbled")
    assert session.pick("R1", 0.45) is None
    assert "this stride of R1 does not count: excluded by hand: stumbled" in session.text()
    assert session.shown_leg == "R1"  # the leg that was clicked, not the pair's L1
    session.pick("R1", 5.0)
    assert "R1 has no whole stride at 5.000 s" in session.text()
    session.undo()
    said = "0 corrections; taken back: excluded stride of R1 at 0.400 s (m1, t1)."
    assert session.text() == said


@pytest.mark.slow
@pytest.mark.filterwarnings(FROM_IPYMPL)
def test_endless_names_of_legs_stay_in_the_picture(spider):
    """Hebrew is left out: its letters are in no font of a bare machine."""
    from pawnb.widgets.gait_explorer import GaitExplorer

    long, script = "a" * 300, "<img src=x onerror=alert(1)>" * 3
    named = {
        field.name: table.replace({"R2": long, "R3": script})
        for field in dataclasses.fields(spider)
        if isinstance(table := getattr(spider, field.name), pd.DataFrame)
    }
    explorer = GaitExplorer(dataclasses.replace(spider, signals=(), **named))
    explorer.session.show_pair(long, script)
    explorer._draw()
    figure = explorer._figure
    figure.canvas.draw()
    for ax in figure.axes:
        for text in (ax.title, ax.xaxis.label, ax.yaxis.label, *ax.get_yticklabels()):
            if text.get_text():
                box = text.get_window_extent()
                assert box.x0 > -8, text
                assert box.x1 < figure.bbox.x1 + 2, text
                assert box.y0 > -2, text
                assert box.y1 < figure.bbox.y1 + 2, text
    explorer.close()


def test_corrections_of_another_file_are_said(tables, tmp_path):
    """Those of a trial by itself are not in the file of its study."""
    session = GaitSession(tables, tmp_path / "trial.jsonl")
    session.pick("R1", 0.45)
    session.exclude_stride("stumbled")
    pooled = replay_event_edits(tables, tmp_path / "trial.jsonl")
    said = GaitSession(pooled, tmp_path / "study.jsonl").text()
    assert "corrections that are not in" in said
    assert "not in" not in GaitSession(pooled, tmp_path / "trial.jsonl").text()
