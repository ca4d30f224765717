"""Which candidates a point took where its path is not certain."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from pawnb.core.parallel import on_threads
from pawnb.core.paws.offline.detection.colour.observations import Sights
from pawnb.core.paws.offline.gap_closing.gap import OpenStretch
from pawnb.core.paws.offline.gap_closing.hypothesis_kernels import Moves
from pawnb.core.paws.offline.gap_closing.limb_clutter import learn_limbs
from pawnb.core.paws.offline.gap_closing.mht import moves_of, state_after
from pawnb.core.paws.offline.gap_closing.mht_kernels import Expected, How, Shown, tell_stretch
from pawnb.core.paws.offline.gap_closing.mht_parameters import Telling
from pawnb.core.paws.offline.gap_closing.rejection import runs, told_anew
from pawnb.core.paws.offline.gap_closing.update_kernels import Cameras
from pawnb.core.paws.offline.gap_closing.wrist_decoys import follow_wrists
from pawnb.core.paws.offline.projection import Geometry
from pawnb.core.paws.offline.scene.motion_model import Manner
from pawnb.core.paws.offline.stride.cycle import Cycle
from pawnb.core.paws.offline.stride.duty_factor import Rhythm
from pawnb.core.paws.offline.stride.stance import Ground, Stance, covered, learn_ground
from pawnb.core.paws.offline.stride.swing import Swings

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
    wrists = follow_wrists(
        stances, sights, ground=ground, geometry=geometry, thickness_px=thickness_px
    )
    places = sure if known.before is None else np.where(np.isnan(sure), known.before, sure)
    telling = _telling(manner)
    teller = _Teller(
        known, *wrists.told(sights, cost), ground, stances, geometry.project(places), telling,
        moves_of(telling, ground.drift, across=manner.axes[1] if len(manner.axes) == 3 else None),
        geometry, thickness_px, np.maximum(_poor_look(sights.quality) - _DIM, 0.0),
    )  # fmt: skip
    choice = np.full((n, n_points, len(thickness_px)), -1)
    held = np.full(known.chosen.shape, np.nan)
    stretches = [
        (p, OpenStretch.of(first, stop, is_open[:, p]))
        for p in range(n_points)
        for first, stop in runs(is_open[:, p])
        # of a stranger nobody has said that it was there
        if first > 0 or known.fixed[:, p].any()
    ]
    told = on_threads(lambda one: teller.tell(*one, own[one[0]]), stretches)
    for (p, stretch), (taken, stood, standing) in zip(stretches, told, strict=True):
        choice[stretch.frames, p] = taken
        held[stretch.frames[stood], p] = standing
    after = ground.stances(np.where(np.isnan(held), sure, held))
    lifts = [(p, one.stop - 1) for p, mine in enumerate(after) for one in mine if one.stop < n]
    choice, cost = wrists.left_out(choice, cost)
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
    moves: Moves  # but for the way in which each stretch is told
    geometry: Geometry
    thickness_px: np.ndarray
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
        manner = self.ground.manner
        state, covariance = state_after(
            self.known.chosen[stretch.before, point], stretch.way * manner.drift,
            telling=self.telling, speed=0.4 * manner.speed,
        )  # fmt: skip
        due = self._due(point, stretch)
        edge, standing = self._standing(point, stretch, is_told=due is not None)
        choice, stood = tell_stretch(
            state, covariance, edge, self._shown(point, stretch, own, standing, due),
            self._expected(point, stretch),
            self._how(point, stretch, own),
        )  # fmt: skip
        return choice, stood, standing[stood]

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
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return where a point stands where a stretch begins, and in its frames (frames, d).

        NaN where it does not stand there, and where nothing follows and it is not told when it
        is due to lift off.
        """
        ground, stance = self.ground, stretch.stance(self.stances[point])
        if stance is None or (stretch.is_last and stretch.way > 0 and not is_told):
            nowhere = np.full((len(stretch.frames), len(ground.drift)), np.nan)
            return nowhere[0], nowhere
        edge = ground.places(stance, stretch.before[-1:])[0]
        return edge, ground.places(stance, stretch.frames)

    def _how(self, point: int, stretch: OpenStretch, own: np.ndarray) -> How:
        """Return how a point is told of."""
        ground, way = self.ground, stretch.way
        # told backwards a paw that stands has not landed yet: how it will is not known
        lift = ground.lift[point] if way > 0 else np.zeros_like(ground.drift)
        return How(
            Cameras(self.geometry.rows, self.thickness_px, own),
            self.moves._replace(drift=way * ground.drift, lift=lift),
            ground.doubts(point, way=way), self.telling,
        )  # fmt: skip

    def _shown(
        self,
        point: int,
        stretch: OpenStretch,
        own: np.ndarray,
        standing: np.ndarray,
        due: np.ndarray | None,
    ) -> Shown:
        """Return what the frames of a stretch show of a point that may stand there.

        ``due`` is what speaks against lifting off before each frame.
        """
        t, sights = stretch.frames, self.sights
        against = self.cost[t, point]
        hidden = covered(
            standing, self.uv[t], point, geometry=self.geometry, thickness_px=self.thickness_px
        )
        return Shown(
            # those that are there come first
            sights.is_there[t].sum(axis=-1), sights.at[t, point],
            np.stack([against, against - self.excused[t]]), np.asarray(hidden[:, own].all(axis=1)),
            self.known.chosen[stretch.after, point],
            np.zeros(len(t) + len(stretch.after)) if due is None else due,
        )  # fmt: skip

    def _expected(self, point: int, stretch: OpenStretch) -> Expected:
        """Return where a point is expected: by the cycle, and by the arc of its swing."""
        cycle, swings, manner = self.known.cycle, self.known.swings, self.ground.manner
        t = np.concatenate([stretch.frames, stretch.after])
        n, most = len(stretch.frames), np.zeros(2)
        at = np.full((2, len(t), len(manner.axes)), np.nan)
        variance, axes = np.ones(at.shape), np.stack([manner.axes] * 2)
        if cycle is not None and stretch.is_last:
            at[0], variance[0] = cycle.mean[t, point], cycle.sd[t, point] ** 2 / _EXPECTED
            axes[0], most[0] = cycle.axes, 0.5 * _EXPECTED * _FARTHEST
        if swings is not None and stretch.way > 0:
            at[1, :n], sd = swings.place[stretch.frames, point], swings.sd[stretch.frames, point]
            sd[:, 1:-1] = np.hypot(sd[:, 1:-1], _ASIDE * manner.thickness)
            weight = _ON_ARC * (_LAST if stretch.is_last else 1.0)
            variance[1, :n], most[1] = sd**2 / weight, 0.5 * weight * _FARTHEST_OFF_ARC
        return Expected(at, variance, axes, most)


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
