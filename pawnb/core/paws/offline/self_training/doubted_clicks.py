"""Clicks that those of the other frames contradict: one of them is of something else.

A clicked frame is tracked without its clicks (:mod:`.weighing`). Where the others surely lead a
point elsewhere, either that click or one of those beside it is of another leg, of the ground, or
was made in another frame. Where the tracker itself is not sure, nothing is said: it loses legs that
look alike, and clicks are right then.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass

import numpy as np
from scipy.special import expit

from pawnb.core.paws.offline.annotations import Annotations
from pawnb.core.paws.offline.quality.calibration import log_odds
from pawnb.core.paws.offline.quality.left_out import LeftOutClick
from pawnb.core.paws.offline.quality.parameters import QUALITY
from pawnb.core.rig import Rig
from pawnb.schema import Tracks

DOUBTED_CLICKS = "doubted_clicks"
"""Attribute of tracks: clicks that others contradict, as JSON (:class:`DoubtedClick`)."""

LOOK_AT_CLICKS = (
    "look at the clicks of these frames (pawnb.widgets.ClickInitialiser), and track again where "
    "one is on another leg, on the ground, or was made in another frame"
)
"""What to do about them."""


@dataclass(frozen=True)
class DoubtedClick:
    """A click that the clicks of other frames contradict.

    Parameters
    ----------
    view : str
        The view.
    frame : int
        The frame.
    point : str
        The point.
    sure : float
        Probability of the place to which the others lead, 0 to 1.
    u, v : float
        Where it is, px of the view.
    other : str
        The point that is clicked there in that frame; empty where none is.
    beside : tuple of int
        The clicked frames before and after it, from which the point was followed: one of these
        clicks may be the wrong one.
    """

    view: str
    frame: int
    point: str
    sure: float
    u: float
    v: float
    other: str = ""
    beside: tuple[int, ...] = ()


def find_doubted_clicks(
    left_out: Sequence[LeftOutClick],
    *,
    points: Sequence[str],
    placed: Mapping[str, Annotations],
    rows: tuple[int, int],
    rig: Rig | None,
) -> list[DoubtedClick]:
    """Find clicks that those of the other frames contradict.

    Parameters
    ----------
    left_out : sequence of LeftOutClick
        Clicks that were left out, of all views.
    points : sequence of str
        Names of the points.
    placed : mapping of str to Annotations
        View to what was clicked in it; row 0 is the first frame.
    rows : tuple of int
        The first frame, and the row of it in which those that were left out are counted from 0.
    rig : Rig, optional
        The calibrated views.
        With it a click that is found in another view is not doubted.

    Returns
    -------
    list of DoubtedClick
        In the order of frames.
    """
    first, begin = rows
    found_in = set() if rig is None else {(c.row, c.point) for c in left_out if c.right}
    told: dict[tuple[int, str], dict[int, LeftOutClick]] = {}
    for click in left_out:
        # what an earlier stretch handed on was not clicked
        clicked = click.point in placed[click.view].places.get(begin + click.row, {})
        if clicked and (click.row, click.point) not in found_in:
            told.setdefault((begin + click.row, click.view), {})[click.point] = click
    doubted = []
    for (row, view), here in sorted(told.items()):
        for p, taken, sure in _of_frame(here):
            u, v = map(float, placed[view].places[row][p])
            own = placed[view].rows_of(p)
            i = own.index(row)
            doubted.append(
                DoubtedClick(
                    view, first + row, points[p], round(sure, 3), u=u, v=v,
                    other="" if taken is None else points[taken],
                    beside=tuple(first + r for r in (*own[max(i - 1, 0) : i], *own[i + 1 : i + 2])),
                )
            )  # fmt: skip
    return doubted


def _of_frame(clicks: dict[int, LeftOutClick]) -> Iterator[tuple[int, int | None, float]]:
    """Return the points of a frame that are doubted, what they were taken for, and how surely."""
    sure = {p: float(expit(log_odds(c.signs[None]))[0]) for p, c in clicks.items()}
    away = {p for p, c in clicks.items() if c.found < QUALITY.doubted_found and not c.right}
    many = {p for p in away if sure[p] >= QUALITY.doubted_together}
    most = len(many) > max(2, len(clicks) / 2)
    for p in sorted(away):
        click, other = clicks[p], clicks[p].taken
        if other is not None:
            each = {p, other} <= many and clicks[other].taken == p
            if each or (sure[p] >= QUALITY.doubted_sure and clicks[other].found < 0.5):
                yield p, other, sure[p]
        elif (
            click.off >= QUALITY.doubted_off
            and click.on_others < QUALITY.doubted_on_others
            and (sure[p] >= QUALITY.doubted_sure or (p in many and most))
        ):
            yield p, None, sure[p]


def doubted_as_attributes(doubted: Sequence[DoubtedClick]) -> dict[str, float | str]:
    """Return doubted clicks as an attribute of tracks, if there are any.

    Parameters
    ----------
    doubted : sequence of DoubtedClick
        The clicks.
    """
    return {DOUBTED_CLICKS: json.dumps([asdict(one) for one in doubted])} if doubted else {}


def doubted_clicks_of(tracks: Tracks) -> list[DoubtedClick]:
    """Return the clicks of tracks that others contradict, and that nobody has moved since.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks.
    """
    rows = json.loads(tracks.attrs.get(DOUBTED_CLICKS, "[]"))
    doubted = [DoubtedClick(**{**row, "beside": tuple(row["beside"])}) for row in rows]
    if not doubted or "image_position" not in tracks:
        return []
    frames, own = tracks["frame"].to_numpy(), tracks["image_position"].isel(individual=0)
    points, views = (tracks[name].to_numpy().tolist() for name in ("keypoint", "view"))

    def is_there(one: DoubtedClick) -> bool:
        if one.frame not in frames or one.point not in points or one.view not in views:
            return False
        at = own.sel(view=one.view, keypoint=one.point).isel(
            time=int(np.argmax(frames == one.frame))
        )
        return bool(np.abs(at.to_numpy() - (one.u, one.v)).max() < QUALITY.stayed_px)

    return [one for one in doubted if is_there(one)]


def doubted_clicks_in_words(doubted: Sequence[DoubtedClick]) -> list[str]:
    """Say which clicks others contradict, each point or pair of points once.

    Parameters
    ----------
    doubted : sequence of DoubtedClick
        The clicks.

    Returns
    -------
    list of str
        Sentences without a full stop, the surest first.
    """
    pairs = {tuple(sorted((one.point, one.other))): one for one in doubted if one.other}
    said = []
    for a, b in pairs:
        own = [one for one in doubted if {one.point, one.other} == {a, b}]
        said.append(f"{a} and {b} seem to be clicked under each other's names in {_frames(own)}")
    alone = [one for one in doubted if not one.other]
    of_frames = {one.frame: {o.point for o in alone if o.frame == one.frame} for one in alone}
    together = [one for one in alone if len(of_frames[one.frame]) > 2]
    if together:
        names = ", ".join(dict.fromkeys(one.point for one in together))
        said.append(
            f"the clicks of {names} in {_frames(together)} lie far from where those of other "
            "frames lead, as if they were made in another frame or not on the animal"
        )
    # what lies between two wrong places is doubted, too
    near = {f for one in together for f in (one.frame, *one.beside)}
    rest = [one for one in alone if one.frame not in near]
    for point in dict.fromkeys(one.point for one in rest):
        own = [one for one in rest if one.point == point]
        said.append(
            f"{point} is clicked far from where the clicks of other frames lead in {_frames(own)}"
        )
    return said


def _frames(doubted: Sequence[DoubtedClick]) -> str:
    """Name the frames, the likeliest first: one that is wrong casts doubt on those beside it."""
    frames = [one.frame for one in doubted]

    def rank(one: DoubtedClick) -> tuple[bool, float]:
        return one.frame in (min(frames), max(frames)), -one.sure

    ranked = sorted(doubted, key=rank)
    named = [one.frame for one in ranked] + [f for one in ranked for f in one.beside]
    first, *others = dict.fromkeys(named)
    return f"frame {first}" + (f" (if not in {' or '.join(map(str, others))})" if others else "")
