"""Which candidates a point took where its path is not certain."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from pawnb.core.paws.whole.bridging import Start, Stories, Telling, state_after
from pawnb.core.paws.whole.cycle import Cycle
from pawnb.core.paws.whole.geometry import Geometry
from pawnb.core.paws.whole.limbs import learn_limbs
from pawnb.core.paws.whole.manner import FASTEST, Manner
from pawnb.core.paws.whole.rhythm import Rhythm
from pawnb.core.paws.whole.sights import Sights
from pawnb.core.paws.whole.standing import Ground, Stance, covered, drawn_off, learn_ground

_LEAST = 4
"""Certain stretches shorter than this are told anew too."""
_BEFORE, _AFTER = 10, 6
"""Certain frames that tell how a stretch begins, and how it ends."""
_LOOK = 1.1
"""Cost of a candidate: so many times minus the logarithm of how much it looks like a paw."""
_OTHER = 8.0
"""Cost of a candidate that lies where another point is."""
_BESIDE = 0.35
"""Distance, in thicknesses, at which it does."""
_EXPECTED = 0.2
"""Weight of a frame's distance from where the cycle has the point, as frames err alike. Only where
nothing certain follows: the cycle of a paw that is hidden in every stride is no more than was made
of it before, and what was told too late once would be told so again."""
_KICK = 0.8
"""Standard deviation of what lift-off changes of a speed, in that of the fastest swings: front
paws go up at once, by up to 1.3 of it in rendered scenes."""
_RISING_S, _SWINGING_S = 0.008, 0.04
"""Time, s, after lift-off in which a paw is bent and dim, and in which it swings for certain."""
_DIM = 0.7
"""Largest cost of a poor look then."""
_DRAWN_S = 0.012
"""A path that is lost so soon, s, after its point left the place where it stood was drawn off."""
_FARTHEST = 16.0
"""Squared standard deviations beyond which a point off its cycle costs no more."""


@dataclass(frozen=True)
class Bridged:
    """What was taken where paths are not certain.

    Parameters
    ----------
    is_open : ndarray of bool, shape (n, P)
        Frames whose candidates were chosen here.
    choice : ndarray of int, shape (n, P, V)
        Number of the candidate taken, -1 where none.
    against : ndarray, shape (n, P, V, C)
        What speaks against each candidate being each point, minus a logarithm of odds.
    held : ndarray, shape (n, P, d), optional
        Where points stand though no path says so, NaN elsewhere.
    lifts : list of (int, int)
        Number of a point and the last frame in which it stands, for every lift-off.
    ground : Ground, optional
        What points stand on.
    stances : list of list of Stance
        When each point stands.
    """

    is_open: np.ndarray
    choice: np.ndarray
    against: np.ndarray
    held: np.ndarray | None = None
    lifts: list[tuple[int, int]] = field(default_factory=list)
    ground: Ground | None = None
    stances: list[list[Stance]] = field(default_factory=list)


@dataclass(frozen=True)
class Known:
    """What is known of the points so far.

    Parameters
    ----------
    chosen : ndarray, shape (n, P, d)
        Certain places, NaN elsewhere.
    fixed : ndarray of bool, shape (n, P)
        Placed by hand.
    before : ndarray, shape (n, P, d), optional
        Tracks of an earlier round, and
    trust : ndarray, shape (n, P), optional
        how much they are to be believed, 0 to 1.
    cycle : Cycle, optional
        Where points are expected.
    lift : ndarray, shape (P, d), optional
        How much speeds change at lift-off.
    rhythm : Rhythm, optional
        When points lift off.
    """

    chosen: np.ndarray
    fixed: np.ndarray
    before: np.ndarray | None = None
    trust: np.ndarray | None = None
    cycle: Cycle | None = None
    lift: np.ndarray | None = None
    rhythm: Rhythm | None = None


def bridge_gaps(
    known: Known,
    sights: Sights,
    *,
    geometry: Geometry,
    thickness_px: np.ndarray,
    own: np.ndarray,
    manner: Manner,
) -> Bridged:
    """Choose candidates for every point where its path is not certain.

    Parameters
    ----------
    known : Known
        What is known so far.
    sights : Sights
        What every view shows.
    geometry : Geometry
        The views.
    thickness_px : ndarray, shape (V,)
        Thickness of a paw in each view.
    own : ndarray of bool, shape (P, V)
        Which view tracks which point.
    manner : Manner
        How points move.

    Returns
    -------
    Bridged
        The choice.
    """
    n, n_points, _ = known.chosen.shape
    is_open = _told_anew(known, manner)
    sure = np.where(is_open[..., None], np.nan, known.chosen)
    ground = learn_ground(sure, manner, lift=known.lift)
    stances = ground.stances(sure)
    cost = _candidate_costs(known, is_open, sights, geometry, thickness_px)
    choice = np.full((n, n_points, len(thickness_px)), -1)
    telling = _telling(manner)
    places = sure if known.before is None else np.where(np.isnan(sure), known.before, sure)
    uv = geometry.project(places)
    held = np.full(known.chosen.shape, np.nan)
    for p in range(n_points):
        for first, stop in runs(is_open[:, p]):
            if first == 0 and not known.fixed[:, p].any():
                continue  # a stranger: nobody has said that it was there
            stretch = _Stretch.of(first, stop, is_open[:, p])
            state, covariance = state_after(
                known.chosen[stretch.before, p], stretch.way * manner.drift, telling=telling,
                speed=0.4 * manner.speed,
            )  # fmt: skip
            start, standing = _standing(stretch, stances[p], ground, p)
            hidden, due = None, None
            if start is not None:
                due = _due(stretch, stances[p], known.rhythm, p)
                hidden = covered(
                    standing, uv[stretch.frames], p, geometry=geometry, thickness_px=thickness_px
                )
            stories = Stories(
                state, covariance, geometry=geometry, thickness_px=thickness_px, own=own[p],
                telling=telling, start=start,
                across=manner.axes[1] if len(manner.axes) == 3 else None,
            )  # fmt: skip
            _tell(stories, p, stretch, known, sights, cost, ground, hidden, due)
            choice[stretch.frames, p] = stories.best()[: stop - first]
            if len(standing):
                stood = stories.stood()[: stop - first]
                held[stretch.frames[stood], p] = standing[stood]
    after = ground.stances(np.where(np.isnan(held), sure, held))
    lifts = [(p, one.stop - 1) for p, mine in enumerate(after) for one in mine if one.stop < n]
    return Bridged(is_open, choice, cost, held, lifts, ground, after)


def _told_anew(known: Known, manner: Manner) -> np.ndarray:
    """Return the frames (n, P) in which points are not certain, or were drawn off."""
    certain = np.isfinite(known.chosen[..., 0])
    is_open = np.stack(
        [open_frames(*of) for of in zip(certain.T, known.fixed.T, strict=True)], axis=1
    )
    sure = np.where(is_open[..., None], np.nan, known.chosen)
    for p, mine in enumerate(learn_ground(sure, manner).stances(sure)):
        lost = drawn_off(mine, is_open[:, p], most=round(_DRAWN_S * _fps(manner)))
        is_open[lost & ~known.fixed[:, p], p] = True
    return is_open


def _telling(manner: Manner) -> Telling:
    """Return how stories are told of points that move so."""
    fps = _fps(manner)
    return Telling(
        jerk=manner.jerk, kick=_KICK * manner.speed,
        noise=0.25 * manner.thickness, reach=1.5 * manner.span,
        rising=max(1, round(_RISING_S * fps)), swinging=round(_SWINGING_S * fps),
    )  # fmt: skip


def _fps(manner: Manner) -> float:
    """Return the frames per second of a recording in which points move so."""
    return FASTEST * manner.span / manner.speed


def _due(
    stretch: _Stretch, stances: Sequence[Stance], rhythm: Rhythm | None, point: int
) -> np.ndarray | None:
    """Return what speaks against lifting off before each frame of a stretch and after it."""
    now = stretch.stance(stances)
    if rhythm is None or now is None or stretch.way < 0:
        return None
    later = [one for one in stances if one.first >= now.stop]
    frames = np.concatenate([stretch.frames, stretch.after])
    return rhythm.due(point, now, later[0] if later else None, frames=frames)


def _standing(
    stretch: _Stretch, stances: Sequence[Stance], ground: Ground, point: int
) -> tuple[Start | None, np.ndarray]:
    """Return how a point stands where a stretch begins, and where it would be in its frames.

    Nothing and no places where it does not stand there.
    """
    stance = stretch.stance(stances)
    if stance is None:
        return None, np.empty((0, len(ground.drift)))
    # told backwards a paw that stands has not landed yet: how it will is not known
    lift = ground.lift[point] if stretch.way > 0 else np.zeros_like(ground.drift)
    edge = ground.places(stance, stretch.before[-1:])[0]
    start = Start(edge, stretch.way * ground.drift, lift)
    return start, ground.places(stance, stretch.frames)


@dataclass(frozen=True)
class _Stretch:
    """Frames of a point that are told anew, in the order in which they are told.

    Parameters
    ----------
    before, frames, after : ndarray of int
        Certain frames that tell how it begins, its own, and certain ones that tell how it ends.
    is_last : bool
        Whether hardly anything follows.
    way : int
        +1, or -1 where it is told backwards in time.
    """

    before: np.ndarray
    frames: np.ndarray
    after: np.ndarray
    is_last: bool
    way: int

    @classmethod
    def of(cls, first: int, stop: int, is_open: np.ndarray) -> _Stretch:
        """Return the stretch ``first`` to ``stop`` (exclusive); the first one goes backwards."""
        n = len(is_open)
        frames = np.arange(n)
        if first == 0:
            # before the first frame nothing is known: it is told from what follows
            begin = stop + _certain_frames(is_open[stop:], _BEFORE)
            return cls(frames[stop:begin][::-1], frames[:stop][::-1], frames[:0], True, -1)
        # going back from the stretch is going forward in reversed time
        begin = first - _certain_frames(is_open[:first][::-1], _BEFORE)
        end = stop + _certain_frames(is_open[stop:], _AFTER)
        return cls(frames[begin:first], frames[first:stop], frames[stop:end], stop + _AFTER > n, 1)

    def stance(self, stances: Sequence[Stance]) -> Stance | None:
        """Return the stance of the point where the stretch begins; None where it does not stand.

        Where nothing follows that says when it lifted off, that is left open.
        """
        if not len(self.before) or (self.is_last and self.way > 0):
            return None
        edge = int(self.before[-1])
        ends = [one.stop - 1 if self.way > 0 else one.first for one in stances]
        return stances[ends.index(edge)] if edge in ends else None


def _tell(
    stories: Stories,
    point: int,
    stretch: _Stretch,
    known: Known,
    sights: Sights,
    cost: np.ndarray,
    ground: Ground,
    hidden: np.ndarray | None,
    due: np.ndarray | None,
) -> None:
    """Lead stories through a stretch and the certain places after it.

    ``hidden`` tells in which views (frames, V) another paw covers the point if it stands, and
    ``due`` what speaks against lifting off before each frame.
    """

    def doubt(x: np.ndarray, speed: np.ndarray, recent: np.ndarray) -> np.ndarray:
        speed = stretch.way * speed
        return ground.manner.strangeness(x, speed) + ground.riding(point, x, speed, recent=recent)

    for told, t in enumerate((*stretch.frames.tolist(), *stretch.after.tolist())):
        is_certain = told >= len(stretch.frames)
        stories.advance(lifting=0.0 if due is None else float(due[told]))
        if is_certain:
            stories.stand(known.chosen[t, point])
        else:
            for v, number in enumerate(sights.is_there[t].sum(axis=-1).tolist()):
                # those that are there come first
                against = cost[t, point, v, :number]
                poor = _poor_look(sights.quality[t, v, :number])
                stories.see(
                    v, sights.at[t, point, v, :number], against,
                    rising=against - np.maximum(poor - _DIM, 0.0),
                )  # fmt: skip
        if known.cycle is not None and stretch.is_last:
            stories.expect(
                known.cycle.mean[t, point], known.cycle.axes,
                known.cycle.sd[t, point] ** 2 / _EXPECTED, most=0.5 * _EXPECTED * _FARTHEST,
            )  # fmt: skip
        cover = None if is_certain or hidden is None else hidden[told]
        stories.settle(doubt, certain=is_certain, covered=cover)


def _poor_look(quality: np.ndarray) -> np.ndarray:
    """Return what speaks against candidates for how much they look like paws."""
    return np.asarray(-_LOOK * np.log(np.clip(quality, 0.02, 1.0)))


def _candidate_costs(
    known: Known,
    is_open: np.ndarray,
    sights: Sights,
    geometry: Geometry,
    thickness_px: np.ndarray,
) -> np.ndarray:
    """Return what speaks against each candidate (n, P, V, C) being each point."""
    n, n_points, _ = known.chosen.shape
    x = np.where(is_open[..., None], np.nan, known.chosen)
    trust = np.ones((n, n_points))
    if known.before is not None and known.trust is not None:
        x = np.where(np.isfinite(x), x, known.before)
        trust = np.where(is_open, known.trust, 1.0)
    there = np.isfinite(x[..., 0])
    uv = geometry.project(np.nan_to_num(x))
    poor = _poor_look(sights.quality)
    cost = np.repeat(poor[:, None], n_points, axis=1)
    explained = np.zeros((n, n_points, *poor.shape[1:]))
    for p in range(n_points):
        away = np.linalg.norm(sights.at[:, p] - uv[:, p, :, None], axis=-1)
        away = np.where(sights.is_there, away, np.inf)
        near = np.exp(-((away / (_BESIDE * thickness_px[:, None])) ** 2))
        # one candidate is enough to explain a point
        near[away > away.min(axis=-1, keepdims=True)] = 0.0
        explained[:, p] = np.where(there[:, p], trust[:, p], 0.0)[:, None, None] * near
    believed = np.where(there, trust, 0.0)
    limbs = learn_limbs(uv, believed, sights, thickness_px=thickness_px)
    for p in range(n_points):
        limb = limbs.against(uv[:, p], sights, p, thickness_px=thickness_px)
        limb = believed[:, p, None, None] * limb
        explained[:, p] = np.maximum(_OTHER * explained[:, p], limb)
    for p in range(n_points):
        others = np.delete(explained, p, axis=1)
        if others.shape[1]:
            cost[:, p] += others.max(axis=1)
    return cost


def open_frames(certain: np.ndarray, fixed: np.ndarray) -> np.ndarray:
    """Return the frames (n,) of one point whose candidates are to be chosen.

    Parameters
    ----------
    certain : ndarray of bool, shape (n,)
        Frames with a certain place.
    fixed : ndarray of bool, shape (n,)
        Those placed by hand; they stay.
    """
    is_open = ~certain
    for first, stop in runs(certain):
        if stop - first < _LEAST:
            is_open[first:stop] = True
    return np.asarray(is_open & ~(fixed & certain))


def runs(mask: np.ndarray) -> list[tuple[int, int]]:
    """Return first frame and one past the last of every run of True."""
    edge = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(int)))
    return [(int(a), int(b)) for a, b in edge.reshape(-1, 2)]


def _certain_frames(is_open: np.ndarray, most: int) -> int:
    """Return how many frames are certain before the first open one, at most ``most``."""
    near = is_open[:most]
    return int(np.argmax(near)) if near.any() else len(near)
