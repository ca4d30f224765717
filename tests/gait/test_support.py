"""Support and stability: polygons by hand, the thesis's limits, footfall orders by definition."""

import itertools

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from pawnb.errors import InputError
from pawnb.gait.support import (
    regularity_index,
    static_stability,
    support_shares,
    support_table,
    wave_gait_margin,
    whole_stretches,
)

SQUARE = np.array([[[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]]])
ALL = np.ones((1, 4), dtype=bool)


def stability(centre, *, feet=SQUARE, down=ALL, forward=(1.0, 0.0)):
    return static_stability(feet, down, np.array([centre]), forward=np.array([forward]))


def test_square_of_feet():
    found = stability((0.5, 0.0))
    assert found.n_down[0] == 4
    assert found.area[0] == pytest.approx(4.0)
    assert found.margin[0] == pytest.approx(0.5)
    assert found.longitudinal_margin[0] == pytest.approx(0.5)
    # along the diagonal the way to the front edges is longer than the least distance
    slanted = stability((0.0, 0.0), forward=(1.0, 1.0))
    assert slanted.margin[0] == pytest.approx(1.0)
    assert slanted.longitudinal_margin[0] == pytest.approx(np.sqrt(2.0))


def test_outside_is_negative_and_two_feet_carry_nothing():
    found = stability((1.5, 0.0))
    assert found.margin[0] == pytest.approx(-0.5)
    assert found.longitudinal_margin[0] == pytest.approx(-0.5)
    assert np.isnan(stability((0.0, 3.0)).longitudinal_margin[0])
    two = stability((0.0, 0.0), down=np.array([[True, True, False, False]]))
    assert (two.n_down[0], two.area[0]) == (2, 0.0)
    assert np.isnan(two.margin[0])
    line = np.array([[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0]]])
    assert np.isnan(stability((0.0, 0.0), feet=line).margin[0])


@given(
    feet=arrays(float, (1, 5, 2), elements=st.floats(-5, 5).map(lambda v: round(v, 2))),
    centre=st.tuples(st.floats(-5, 5), st.floats(-5, 5)),
    turn=st.floats(0, 6.28),
)
def test_margins_do_not_depend_on_the_axes(feet, centre, turn):
    down = np.ones((1, 5), dtype=bool)
    c, s = np.cos(turn), np.sin(turn)
    rotate = np.array([[c, s], [-s, c]])
    one = stability(centre, feet=feet, down=down)
    two = stability(
        np.array(centre) @ rotate + 7, feet=feet @ rotate + 7, down=down, forward=(c, s)
    )
    if one.area[0] < 1e-3:
        return  # feet on a line, to rounding
    np.testing.assert_allclose(one.margin, two.margin, atol=1e-9)
    np.testing.assert_allclose(one.area, two.area, atol=1e-9)
    # inside the polygon no direction is shorter than the least distance to an edge
    if one.margin[0] > 0:
        assert one.longitudinal_margin[0] >= one.margin[0] - 1e-9


def test_wave_gaits_become_unstable_where_the_thesis_says():
    # Pullar 2009: eight legs at 0.375; insects at a half, quadrupeds at three quarters
    assert wave_gait_margin(0.375, n_legs=8) == 0.0
    assert wave_gait_margin(0.5, n_legs=6) == 0.0
    assert wave_gait_margin(0.75, n_legs=4) == 0.0
    # Table 4.5: duty factor 0.550 at rest gives the margin 0.350
    assert wave_gait_margin(0.550, n_legs=8) == pytest.approx(0.350)
    with pytest.raises(InputError, match="percent"):
        wave_gait_margin(55.0, n_legs=8)
    with pytest.raises(InputError, match="four legs or more"):
        wave_gait_margin(0.5, n_legs=2)


def events(order, *, step=0.1, duty=0.25):
    rows = []
    for i, leg in enumerate(order):
        for kind, t in (("TD", i * step), ("LO", i * step + duty)):
            rows.append({"animal": "a", "trial": "t", "leg": leg, "event": kind, "time_s": t})
    return pd.DataFrame(rows)


def test_feet_on_the_ground():
    table = support_table(events(["FR", "HL", "FL", "HR"] * 3))
    # a foot lands every 0.1 s and stays 0.25 s: three down for 0.05 s, two for 0.05 s, in turn
    shares = support_shares(table).set_index("n_down")["share"]
    assert shares[2] == pytest.approx(0.5, abs=0.05)
    assert shares[3] == pytest.approx(0.5, abs=0.05)
    row = table[(table["start_s"] < 0.62) & (table["end_s"] > 0.62)].iloc[0]
    # by hand: at 0.62 s FL (0.6), HL (0.5) and FR (0.4) are down, HR left at 0.55 s
    assert row["legs"] == "FR+FL+HL"


def strides_of(landings, period=0.4):
    """Strides of each leg from its landings that follow each other after one period."""
    rows = [
        ("a", "t", leg, t, period)
        for leg, own in landings.groupby("leg")["time_s"]
        for t, after in itertools.pairwise(own)
        if after - t < 1.5 * period
    ]
    return pd.DataFrame(rows, columns=["animal", "trial", "leg", "start_s", "period_s"])


def test_a_pause_is_no_support():
    # two bouts of three rounds, 10 s apart: the animal stands between, and that does not count
    first = events(["FR", "HL", "FL", "HR"] * 3)
    later = first.assign(time_s=first["time_s"] + 10.0)
    both = pd.concat([first, later], ignore_index=True)
    strides = strides_of(both[both["event"] == "TD"])
    spans = whole_stretches(both, strides)
    # by hand: HR lands first at 0.3 s, FR last at 0.8 s; then 10 s later
    assert spans[["start_s", "end_s"]].to_numpy().ravel() == pytest.approx([0.3, 0.8, 10.3, 10.8])
    table = support_table(both, strides=strides)
    assert (table["end_s"] - table["start_s"]).sum() == pytest.approx(1.0)
    shares = support_shares(table).set_index("n_down")["share"]
    assert shares.to_dict() == pytest.approx({2: 0.5, 3: 0.5})
    # without strides the pause was most of it
    assert support_shares(support_table(both))["share"].max() > 0.8
    # a leg with events and no stride: nothing is known of all feet
    lame = strides[strides["leg"] != "HL"]
    assert whole_stretches(both, lame).empty
    assert support_table(both, strides=lame).empty


def test_no_sequence_goes_on_across_a_pause():
    order = ["FR", "HR", "FL", "HL"] * 2 + ["FR", "HR"]
    two = events(order)
    two.loc[two["time_s"] >= 0.8, "time_s"] += 5.0
    one = regularity_index(events([*order, "FL", "HL"]))
    assert one.n_sequences == 3
    spans = pd.DataFrame({"start_s": [0.0, 5.8], "end_s": [0.7, 6.0]})
    both = regularity_index(two, stretches=spans)
    assert (both.n_footfalls, both.n_sequences) == (10, 2)
    with pytest.raises(InputError, match="needs four footfalls in one stretch"):
        regularity_index(two, stretches=spans.tail(1))


def test_regularity_index():
    regular = regularity_index(events(["FR", "HR", "FL", "HL"] * 5))
    assert regular.percent == 100.0
    assert regular.shares["Aa"] == 1.0
    # one foot lands twice out of turn: three whole sequences among 15 footfalls remain
    faulty = ["FR", "HR", "FL", "HL"] * 2 + ["FR", "FR"] + ["HR", "FL", "HL"] + ["FR", "HR"]
    found = regularity_index(events(faulty))
    assert found.n_footfalls == 15
    assert found.n_sequences == 3
    assert found.percent == pytest.approx(100 * 12 / 15)
    with pytest.raises(InputError, match="needs footfalls of FR, HR, FL and HL"):
        regularity_index(events(["L1", "R1"] * 4))
