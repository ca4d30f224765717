"""The tables of coordination of a walking animal with known phases."""

import pytest
from walking import Walk

from pawnb.gait import analyse, analyse_events
from pawnb.gait.coordination import coordination_tables


def test_a_trot_is_a_trot_in_every_table():
    tables = analyse(Walk().tracks())
    found = coordination_tables(tables)
    assert set(found) == {
        "support", "support_rule", "support_shares", "regularity", "symmetry", "coupling",
        "alternation", "patterns",
    }  # fmt: skip
    assert found["patterns"].iloc[0]["pattern"] == "trot"
    assert found["patterns"].iloc[0]["distance"] < 0.01
    shares = found["support_shares"].set_index("n_down")["share"]
    # diagonal pairs half a cycle apart: of each half cycle all four feet are down for as long
    # as contact outlasts it; contact as found, which begins a little early on smooth swings
    duty = tables.strides["contact_duty_factor"].mean()
    assert shares[4] == pytest.approx(2 * duty - 1, abs=0.02)
    assert shares[2] == pytest.approx(2 - 2 * duty, abs=0.02)
    assert found["symmetry"]["symmetry_index"].abs().max() < 5.0
    assert (found["alternation"]["from_half"].abs() < 0.01).all()


def test_one_leg_alone_has_few_tables_and_no_exception():
    tables = analyse(Walk().tracks())
    alone = analyse_events(tables.events[tables.events["leg"] == "FR"])
    found = coordination_tables(alone)
    assert set(found) == {"support", "support_shares"}
