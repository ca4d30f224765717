"""Detections as ratios of likelihoods, and kinds of evidence that other packages offer."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from pawnb.core.paws.offline.annotations import Annotations
from pawnb.core.paws.offline.detection import evidence
from pawnb.core.paws.offline.detection.evidence import (
    Detections,
    bump_at,
    found_by,
    paint,
)
from pawnb.errors import InputError


def detections(*rows):
    row, point, u, v, log_odds, sd = np.array(rows, float).T
    return Detections(row.astype(int), point.astype(int), np.stack([u, v], -1), log_odds, sd)


@pytest.fixture
def stack(make_stack):
    return make_stack(np.zeros((3, 60, 90), np.uint8))


def test_painted_detections_are_one_plus_the_sum_of_their_gaussians(stack):
    """Two in one picture overlap; one lies at the edge, one outside, one is another point's."""
    found = detections(
        (0, 4, 40.0, 31.0, 2.0, 6.0),
        (0, 4, 46.0, 25.0, 1.0, 4.5),
        (1, 4, 0.0, 58.0, 3.0, 7.0),
        (1, 4, 500.0, -90.0, 3.0, 7.0),
        (2, 5, 40.0, 31.0, 2.0, 6.0),
    )
    expected = np.ones((3, 20, 30))
    for row, point, (u, v), log_odds, sd in zip(
        found.row, found.point, found.uv, found.log_odds, found.sd_px, strict=True
    ):
        for y in range(20):
            for x in range(30):
                # places of the grid lie 3 px apart, the first at (1, 1)
                away2 = (3 * x + 1 - u) ** 2 + (3 * y + 1 - v) ** 2
                if point == 4:
                    expected[row, y, x] += np.exp(log_odds - away2 / (2 * sd**2))
    # beyond 4 standard deviations nothing is painted: exp(3 - 8) = 0.007
    np.testing.assert_allclose(paint(found, stack, 4), expected, atol=0.007)
    assert paint(found, stack, 4)[0].max() > 5


def test_a_sharp_detection_is_still_as_wide_as_half_a_place(stack):
    ratio = paint(detections((0, 0, 31.0, 31.0, 0.0, 0.1)), stack, 0)[0]
    assert ratio[10, 10] == pytest.approx(2)
    assert ratio[10, 11] == pytest.approx(1 + np.exp(-2))  # one place is two of its 0.5


def test_detections_outside_the_recording_or_without_a_position_are_left_out(stack):
    found = detections(
        (-1, 0, 9.0, 9.0, 1.0, 3.0), (3, 0, 9.0, 9.0, 1.0, 3.0), (1, 0, np.nan, 9.0, 1.0, 3.0),
        (2, 0, 10.0, 11.0, 1.5, 3.5),
    )  # fmt: skip
    kept = found.within(3)
    assert [(*kept.row, *kept.point, *kept.uv[0], *kept.log_odds, *kept.sd_px)] == [
        (2, 0, 10.0, 11.0, 1.5, 3.5)
    ]
    assert (paint(found, stack, 0)[:2] == 1).all()


def test_bump_is_one_at_its_place_and_falls_by_the_standard_deviation():
    bump = bump_at((7, 9), (4, 2), 2.0)
    assert bump.shape == (7, 9)
    assert bump[2, 4] == 1
    assert bump[2, 6] == pytest.approx(np.exp(-0.5))
    assert bump[6, 4] == pytest.approx(np.exp(-2))


class Net:
    """A kind of evidence of another package."""

    name = "net"


def offered(load):
    return SimpleNamespace(name="net", value="other.package:Net", load=load)


def test_other_packages_offer_kinds_by_entry_points(monkeypatch):
    asked = []

    def entry_points(*, group):
        asked.append(group)
        return [offered(lambda: Net)]

    monkeypatch.setattr(evidence, "entry_points", entry_points)
    (kind,) = evidence.installed_evidence()
    assert isinstance(kind, Net)
    assert asked == ["pawnb.evidence"]


def missing():
    raise ModuleNotFoundError("No module named 'other'")


def refuses():
    def kind():
        raise RuntimeError("no weights are there")

    return kind


@pytest.mark.parametrize(("load", "why"), [(missing, "'other'"), (refuses, "no weights")])
def test_a_kind_that_cannot_be_loaded_or_made_is_named(monkeypatch, load, why):
    monkeypatch.setattr(evidence, "entry_points", lambda **_: [offered(load)])
    with pytest.raises(InputError, match=rf"'net' of other.package:Net cannot be used: .*{why}"):
        evidence.installed_evidence()


class Answers:
    """A kind of evidence that returns what it is told to."""

    name = "net"

    def __init__(self, answer):
        self.answer = answer

    def detect(self, view, stack, annotations, *, points):
        if isinstance(self.answer, Exception):
            raise self.answer
        return self.answer


def two(**changed):
    usual = {
        "row": [0, 1], "point": [0, 1], "uv": [[4, 5], [np.nan, 3]], "log_odds": [2, 1],
        "sd_px": [1, 2],
    }  # fmt: skip
    return SimpleNamespace(**{**usual, **changed})


def test_lists_of_another_package_become_arrays(stack):
    found = found_by(
        Answers(two()), "cam1", stack, annotations=Annotations({}), points=("FR", "HR")
    )
    assert found.within(3).uv.tolist() == [[4.0, 5.0]]
    assert found.part(1, 2).row.tolist() == [0]


@pytest.mark.parametrize(
    ("answer", "message"),
    [
        (ValueError("no weights"), r"fails: ValueError: no weights \(view 'cam1'\)"),
        (None, r"fails: AttributeError"),
        (two(log_odds=[1.0]), r"returns row, .* of shapes \(2,\), \(2,\), \(2, 2\), \(1,\), \(2,"),
        (two(point=[0, 7]), r"returns points 0 to 7; there are 0 to 1"),
        (two(row=[0.0, 1.0]), r"returns rows or points that are no whole numbers"),
        (two(log_odds=[np.inf, 1]), r"returns log_odds or sd_px that are no finite numbers"),
        (two(sd_px=[-1.0, 1]), r"returns an sd_px below 0"),
    ],
)
def test_what_another_package_finds_is_looked_through(stack, answer, message):
    with pytest.raises(InputError, match=rf"^the kind of evidence 'net' {message}") as caught:
        found_by(Answers(answer), "cam1", stack, annotations=Annotations({}), points=("FR", "HR"))
    assert str(caught.value).endswith("mend or remove the package that offers it.")
