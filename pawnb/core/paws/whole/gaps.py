"""Which candidates a point took where its path is not certain."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from pawnb.core.paws.whole.bridging import Start, Stories, Telling, state_after
from pawnb.core.paws.whole.cycle import Cycle
from pawnb.core.paws.whole.doubted import runs, told_anew
from pawnb.core.paws.whole.geometry import Geometry
from pawnb.core.paws.whole.limbs import learn_limbs
from pawnb.core.paws.whole.manner import Manner
from pawnb.core.paws.whole.open_stretch import OpenStretch
from pawnb.core.paws.whole.rhythm import Rhythm
from pawnb.core.paws.whole.sights import Sights
from pawnb.core.paws.whole.standing import Ground, Stance, covered, learn_ground
from pawnb.core.paws.whole.swings import Swings

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
_ON_ARC, _LAST = 0.2, 2.0
"""Weight of a frame's distance from the arc of its swing, and so much more where nothing certain
follows."""
_ASIDE = 0.7
"""Standard deviation, in thicknesses, of how far aside of its arc a paw swings."""
_FARTHEST_OFF_ARC = 9.0
"""Squared standard deviations beyond which a point off its arc costs no more: an arc may be of a
stance that was told wrongly."""
_KICK = 0.8
"""Standard deviation of what lift-off changes of a speed, in that of the fastest swings: front
paws go up at once, by up to 1.3 of it in rendered scenes."""
_RISING_S, _SWINGING_S = 0.008, 0.04
"""Time, s, after lift-off in which a paw is bent and dim, and in which it swings for certain."""
_DIM = 0.7
"""Largest cost of a poor look then."""
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
    swings : Swings, optional
        Where they swing.
    """

    chosen: np.ndarray
    fixed: np.ndarray
    before: np.ndarray | None = None
    trust: np.ndarray | None = None
    cycle: Cycle | None = None
    lift: np.ndarray | None = None
    rhythm: Rhythm | None = None
    swings: Swings | None = None


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
    is_open = told_anew(
        known.chosen, known.fixed, manner=manner, rhythm=known.rhythm, swings=known.swings
    )
    sure = np.where(is_open[..., None], np.nan, known.chosen)
    ground = learn_ground(sure, manner, lift=known.lift)
    stances = ground.stances(sure)
    cost = _candidate_costs(known, is_open, sights, geometry, thickness_px)
    places = sure if known.before is None else np.where(np.isnan(sure), known.before, sure)
    teller = _Teller(
        known, sights, cost, ground, stances, geometry.project(places), _telling(manner), geometry,
        thickness_px, sights.is_there.sum(axis=-1).tolist(),
        np.maximum(_poor_look(sights.quality) - _DIM, 0.0),
    )  # fmt: skip
    choice = np.full((n, n_points, len(thickness_px)), -1)
    held = np.full(known.chosen.shape, np.nan)
    for p in range(n_points):
        for first, stop in runs(is_open[:, p]):
            if first == 0 and not known.fixed[:, p].any():
                continue  # a stranger: nobody has said that it was there
            stretch = OpenStretch.of(first, stop, is_open[:, p])
            choice[stretch.frames, p], stood, standing = teller.tell(p, stretch, own[p])
            held[stretch.frames[stood], p] = standing
    after = ground.stances(np.where(np.isnan(held), sure, held))
    lifts = [(p, one.stop - 1) for p, mine in enumerate(after) for one in mine if one.stop < n]
    return Bridged(is_open, choice, cost, held, lifts, ground, after)


def _telling(manner: Manner) -> Telling:
    """Return how stories are told of points that move so."""
    fps = manner.fps
    return Telling(
        jerk=manner.jerk, kick=_KICK * manner.speed,
        noise=0.25 * manner.thickness, reach=1.5 * manner.span,
        rising=max(1, round(_RISING_S * fps)), swinging=round(_SWINGING_S * fps),
    )  # fmt: skip


@dataclass(frozen=True)
class _Teller:
    """Tells what points did where they are not certain; see :func:`bridge_gaps`."""

    known: Known
    sights: Sights
    cost: np.ndarray  # (n, P, V, C)
    ground: Ground
    stances: list[list[Stance]]
    uv: np.ndarray  # (n, P, V, 2), where all points are as far as is known
    telling: Telling
    geometry: Geometry
    thickness_px: np.ndarray
    numbers: list[list[int]]  # candidates of each frame and view
    excused: np.ndarray  # (n, V, C), how much of a poor look a paw that lifts off is forgiven

    def tell(
        self, point: int, stretch: OpenStretch, own: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Tell a stretch.

        Returns
        -------
        choice : ndarray of int, shape (frames, V)
            The candidates taken.
        stood : ndarray of bool, shape (frames,)
            Where the point stands, and
        standing : ndarray, shape (stood frames, d)
            on which places.
        """
        manner, n = self.ground.manner, len(stretch.frames)
        state, covariance = state_after(
            self.known.chosen[stretch.before, point], stretch.way * manner.drift,
            telling=self.telling, speed=0.4 * manner.speed,
        )  # fmt: skip
        due = self._due(point, stretch)
        start, standing = self._standing(point, stretch, is_told=due is not None)
        hidden = None
        if start is not None:
            hidden = covered(
                standing, self.uv[stretch.frames], point, geometry=self.geometry,
                thickness_px=self.thickness_px,
            )  # fmt: skip
        stories = Stories(
            state, covariance, geometry=self.geometry, thickness_px=self.thickness_px, own=own,
            telling=self.telling, start=start,
            across=manner.axes[1] if len(manner.axes) == 3 else None,
        )  # fmt: skip
        self._lead(stories, point, stretch, hidden, due)
        if start is None:
            return stories.best()[:n], np.zeros(n, bool), standing
        stood = stories.stood()[:n]
        return stories.best()[:n], stood, standing[stood]

    def _due(self, point: int, stretch: OpenStretch) -> np.ndarray | None:
        """Return what speaks against lifting off before each frame of a stretch and after it.

        Nothing where nothing is known of it: of the swing itself, or of the rhythm.
        """
        if stretch.way < 0:
            return None
        known, stances = self.known, self.stances[point]
        frames = np.concatenate([stretch.frames, stretch.after])
        if known.swings is not None:
            due = known.swings.due(point, frames, self.ground.manner.fps)
            if due is not None:
                return due
        now = stretch.stance(stances)
        # where nothing follows that says when it lifted off, that is left open
        if known.rhythm is None or now is None or stretch.is_last:
            return None
        later = [one for one in stances if one.first >= now.stop]
        return known.rhythm.due(point, now, later[0] if later else None, frames=frames)

    def _standing(
        self, point: int, stretch: OpenStretch, *, is_told: bool
    ) -> tuple[Start | None, np.ndarray]:
        """Return how a point stands where a stretch begins, and where it would be in its frames.

        Nothing and no places where it does not stand there, and where nothing follows and it is
        not told when it is due to lift off.
        """
        ground, stance = self.ground, stretch.stance(self.stances[point])
        if stance is None or (stretch.is_last and stretch.way > 0 and not is_told):
            return None, np.empty((0, len(ground.drift)))
        # told backwards a paw that stands has not landed yet: how it will is not known
        lift = ground.lift[point] if stretch.way > 0 else np.zeros_like(ground.drift)
        edge = ground.places(stance, stretch.before[-1:])[0]
        start = Start(edge, stretch.way * ground.drift, lift)
        return start, ground.places(stance, stretch.frames)

    def _lead(
        self,
        stories: Stories,
        point: int,
        stretch: OpenStretch,
        hidden: np.ndarray | None,
        due: np.ndarray | None,
    ) -> None:
        """Lead stories through a stretch and the certain places after it.

        ``hidden`` tells in which views (frames, V) another paw covers the point if it stands, and
        ``due`` what speaks against lifting off before each frame.
        """
        ground, sights = self.ground, self.sights

        def doubt(x: np.ndarray, speed: np.ndarray, recent: np.ndarray) -> np.ndarray:
            speed = stretch.way * speed
            riding = ground.riding(point, x, speed, recent=recent)
            return ground.manner.strangeness(x, speed) + riding

        for told, t in enumerate((*stretch.frames.tolist(), *stretch.after.tolist())):
            is_certain = told >= len(stretch.frames)
            stories.advance(lifting=0.0 if due is None else float(due[told]))
            if is_certain:
                stories.stand(self.known.chosen[t, point])
            else:
                for v, number in enumerate(self.numbers[t]):
                    # those that are there come first
                    against = self.cost[t, point, v, :number]
                    stories.see(
                        v, sights.at[t, point, v, :number], against,
                        rising=against - self.excused[t, v, :number],
                    )  # fmt: skip
            self._expect(stories, point, stretch, t, is_certain=is_certain)
            cover = None if is_certain or hidden is None else hidden[told]
            stories.settle(doubt, certain=is_certain, covered=cover)

    def _expect(
        self, stories: Stories, point: int, stretch: OpenStretch, t: int, *, is_certain: bool
    ) -> None:
        """Let stories take in where the point is expected in a frame, if that is known."""
        cycle, swings, manner = self.known.cycle, self.known.swings, self.ground.manner
        if cycle is not None and stretch.is_last:
            stories.expect(
                cycle.mean[t, point], cycle.axes, cycle.sd[t, point] ** 2 / _EXPECTED,
                most=0.5 * _EXPECTED * _FARTHEST,
            )  # fmt: skip
        if swings is None or is_certain or stretch.way < 0:
            return
        place, sd = swings.place[t, point], swings.sd[t, point].copy()
        if np.isfinite(place).all():
            sd[1:-1] = np.hypot(sd[1:-1], _ASIDE * manner.thickness)
            weight = _ON_ARC * (_LAST if stretch.is_last else 1.0)
            stories.expect(
                place, manner.axes, sd**2 / weight, most=0.5 * weight * _FARTHEST_OFF_ARC
            )


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
