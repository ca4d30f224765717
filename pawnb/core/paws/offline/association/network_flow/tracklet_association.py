"""Which pieces of path each point took: the choice over the whole recording."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.ndimage import uniform_filter1d

from pawnb.core.paws.offline.association.network_flow.body_clutter import without_fixtures
from pawnb.core.paws.offline.association.network_flow.contralateral import (
    aside_cost,
    near_side_cost,
    nearer,
    side_cost,
)
from pawnb.core.paws.offline.association.network_flow.min_cost_flow import Flow, FlowCosts
from pawnb.core.paws.offline.association.network_flow.positional_prior import (
    follow_body,
    habit_cost,
    learn_habits,
)
from pawnb.core.paws.offline.association.network_flow.splitting import (
    cut_meetings,
    cut_slides,
    cut_takeovers,
)
from pawnb.core.paws.offline.association.network_flow.tracklets import (
    Linking,
    Tracklet,
    build_tracklets,
    find_drift,
    joined,
    total_costs,
)
from pawnb.core.paws.offline.association.network_flow.triangulation import Pairing, Places
from pawnb.core.paws.offline.detection.colour.detector import worth
from pawnb.core.paws.offline.detection.colour.likelihood import Judge
from pawnb.core.paws.offline.scene.motion_model import FASTEST, Manner
from pawnb.core.paws.offline.scene.treadmill import Scene
from pawnb.core.paws.offline.settings import WholeSettings
from pawnb.core.paws.offline.stride.cycle import Cycle
from pawnb.core.paws.offline.treadmill.median import middle as median

_LOOKS = 2
"""Times that paths are chosen again with the habits learnt from the last choice."""
_HABIT = 0.5
"""Weight of where points rarely are relative to the body: neighbouring frames err alike."""
_EXPECTED = 0.3
"""Half a squared standard deviation from where the cycle has a point, for frames that err alike."""
_FARTHEST = 36.0
"""Squared standard deviations beyond which a point off its cycle costs no more. That cost must be
above what it costs to stay hidden: towards the end of a recording, where no later piece has to be
reached, a point that is lost would else take whatever is there, however far from its own place."""
_TOLD_APART = 0.5
"""Clicks of front and hind paws this many spans apart tell where each usually are."""
_LOOK_BELOW = 3.0
"""What a place looks like counts so much more from below, where nothing hides a paw."""
_ELSEWHERE = 1.5
"""Cost of a place that no view of the point's own shows, in that of being hidden: a hidden paw is
bridged, and one that follows another's is wrong."""
_GOOD = 0.5
"""Largest cost of a place that tells about it."""
_DEAREST, _WORSE = (0.9, 1.2), 0.2
"""Pieces of path are no paw if they cost more a frame; the limit is raised, at most to the second,
to so much above what the clicked paws cost: with their toes spread they look less like ends."""
_MEETING = 3.0
"""Distance, in thicknesses, at which points meet in a picture."""

_BESIDE = 4.0
"""Distance, in thicknesses, at which a piece that ends is beside another."""
_TAKEOVER_S = 0.03
"""Time, s, before and after its end in which the other may take over its point."""
_STOOD_S = 0.015
"""Time, s, for which a paw goes with the ground to be known to stand."""
_WANDERS = 2.0
"""Before the body is followed places to the side are told so much more vaguely: an animal on a belt
wanders. Only where strangers are kept to their side, too: clicked paws hold their own."""

Fixed = Mapping[int, Mapping[int, np.ndarray]]
"""Frame to point number to position, certain."""


class PathChoice:
    """The pieces of a recording and the choice among them.

    Where a view leads, places lie on its plane and have no heights.

    Parameters
    ----------
    found : sequence
        Candidates of every frame and view.
    fixed : mapping
        Frame to point number to position, certain.
    scene : Scene
        What the clicks say.
    fps : float
        Frames per second.
    settings : WholeSettings
        The settings.
    kinds : sequence of str
        Kind of each point: "front", "hind" or "other". Points after the last that was
        clicked are strangers: nobody said where they are.
    judge : Judge
        Tells how much candidates look like paws.
    own : ndarray of bool, shape (P, V)
        Which view tracks which point.

    Attributes
    ----------
    manner : Manner
        How points move.
    body_frames : int
        Frames over which the body is followed: about two strides.
    """

    def __init__(
        self,
        found: Sequence[Sequence[np.ndarray]],
        fixed: Fixed,
        scene: Scene,
        *,
        fps: float,
        settings: WholeSettings,
        kinds: Sequence[str],
        judge: Judge,
        own: np.ndarray,
    ) -> None:
        self.scene, self.kinds = scene, kinds
        lead = scene.lead
        if lead is not None:
            fixed = {t: {p: lead.flat(x) for p, x in here.items()} for t, here in fixed.items()}
        self.fixed = fixed
        self.shape = (len(found), len(kinds), scene.geometry.n_coordinates)
        self.body_frames = max(3, round(settings.body_s * fps))
        places = find_places(found, scene, settings, judge=judge)
        dearest = _DEAREST[0]
        for t, here in fixed.items():
            dearest = max(dearest, _dearest_click(places[t], here, scene.thickness) + _WORSE)
            away = places[t].distance(np.stack(list(here.values())))
            free = away > 1.2 * scene.thickness
            if t == 0:
                free[:] = False
            places[t] = places[t].take(free)
        self._usual = where_kinds_are(places, fixed, scene, kinds=kinds, frames=self.body_frames)
        self.manner = _manner(places, scene, fps, settings)
        noise, speed = settings.noise * scene.thickness, 0.4 * self.manner.speed
        drift = self.manner.drift
        linking = Linking(self.manner.acceleration, noise, speed, drift, 1.6)
        pieces = build_tracklets(places, linking)
        self.pieces = [
            piece for piece, cost in zip(pieces, total_costs(pieces), strict=True)
            if cost / len(piece.picks)
            < (min(dearest, _DEAREST[1]) if len(piece.picks) > 1 else 0.5)
        ]  # fmt: skip
        self._clicked = 1 + max(p for here in fixed.values() for p in here)
        strangers = len(kinds) - self._clicked
        self.pieces = self._cut(self.pieces, fps)
        stay = settings.stay_cost / fps
        costs = FlowCosts(
            self.manner.acceleration, noise, speed, drift, settings.hide_cost, stay,
            max(4, round(settings.longest_gap_s * fps)), settings.links,
        )  # fmt: skip
        self._elsewhere = np.zeros((len(kinds), len(self.pieces)))
        if self.pieces and lead is None and scene.volume is not None:
            frame, at, begins = joined(self.pieces)
            seen = pairing(scene, settings, judge=judge).seen(frame, at, found)
            cost = _ELSEWHERE * stay * seen_elsewhere(seen, own)
            self._elsewhere = np.add.reduceat(cost, begins, axis=1)
        self._flow = Flow(self.pieces, fixed, len(found), costs, strangers=strangers)

    def _cut(self, pieces: list[Tracklet], fps: float) -> list[Tracklet]:
        """Return pieces that lead through no meeting, without those that belong to the body."""
        thickness, drift = self.scene.thickness, self.manner.drift
        if self.scene.lead is not None or self.shape[2] == 2 or self._clicked < len(self.kinds):
            # in one picture points meet that do not meet in space
            pieces = cut_meetings(pieces, _MEETING * thickness)
        else:
            pieces = cut_takeovers(pieces, _BESIDE * thickness, max(3, round(_TAKEOVER_S * fps)))
        pieces = cut_slides(
            pieces, drift=drift, axes=self.manner.axes[[0, -1]], thickness=thickness,
            frames=max(3, round(_STOOD_S * fps)),
        )  # fmt: skip
        return without_fixtures(pieces, drift, thickness=thickness)

    def first(self) -> np.ndarray:
        """Choose by the clicks, then by where points usually are.

        Returns
        -------
        ndarray, shape (n, P, d)
            The chosen places, NaN where hidden.
        """
        start = _start_prior(self.pieces, self._usual, self.fixed, self.scene)
        nowhere = np.zeros((self.shape[0], self.shape[2]))
        start += near_side_cost(self.pieces, self.fixed, self.scene, body=nowhere, kinds=self.kinds)
        x = self._choose(start)
        axes = list(self.manner.axes[:2])
        groups = [self.kinds, [str(p) for p in range(self.shape[1])]][: len(axes)]
        for _ in range(_LOOKS):
            body, span = self.body(x), self.scene.span
            habits = learn_habits(x, body, axes=axes, groups=groups, span=span)
            prior = habit_cost(self.pieces, body, axes=axes, habits=habits, span=span)
            # habits learnt while near and far paws changed places would keep them so
            side = side_cost(self.pieces, self.fixed, self.scene, body=body, kinds=self.kinds)
            x = self._choose(_HABIT * prior + side)
        if self._clicked == len(self.kinds):
            return x
        return nearer(
            x, self.fixed, self.scene, body=self.body(x), kinds=self.kinds, clicked=self._clicked
        )

    def again(self, cycle: Cycle) -> np.ndarray:
        """Choose by where each point is expected at each moment of the stride.

        Returns
        -------
        ndarray, shape (n, P, d)
            The chosen places, NaN where hidden.
        """
        if not self.pieces:
            return self._choose(None)
        frame, at, first = joined(self.pieces)
        square = np.stack(
            [cycle.square(frame, p, self._as_high(at, cycle.mean[frame, p]))
             for p in range(self.shape[1])]
        )  # fmt: skip
        cost = _EXPECTED * np.minimum(square, _FARTHEST)
        return self._choose(np.add.reduceat(cost, first, axis=1))

    def body(self, x: np.ndarray) -> np.ndarray:
        """Return the slowly moving middle (n, d) of tracks (n, P, d) with NaN where hidden."""
        return follow_body(x, self.body_frames)

    def _choose(self, prior: np.ndarray | None) -> np.ndarray:
        """Return where the cheapest chains of pieces go."""
        x = np.full(self.shape, np.nan)
        if self.scene.lead is not None:
            look = _LOOK_BELOW * total_costs(self.pieces)
            prior = look + (0.0 if prior is None else prior) + np.zeros((self.shape[1], 1))
        own = (0.0 if prior is None else prior) + self._elsewhere
        for p, chain in enumerate(self._flow.assign(own)):
            for i in chain:
                x[self.pieces[i].first : self.pieces[i].last + 1, p] = self.pieces[i].at
        for t, here in self.fixed.items():
            for p, at in here.items():
                x[t, p] = at
        return x

    def _as_high(self, at: np.ndarray, expected: np.ndarray) -> np.ndarray:
        """Raise places on the plane of a leading view as high as expected ones (n, d)."""
        if self.scene.lead is None:
            return at
        return self.scene.lead.at_height(at, expected @ self.scene.up)


def _dearest_click(places: Places, here: Mapping[int, np.ndarray], thickness: float) -> float:
    """Return the largest cost of the places where points were put by hand, 0 without any."""
    away = np.linalg.norm(places.at[:, None] - np.stack(list(here.values())), axis=-1)
    if not len(away):
        return 0.0
    cost = places.cost[away.argmin(axis=0)]
    return float(cost[away.min(axis=0) < 0.5 * thickness].max(initial=0.0))


def _manner(places: Sequence[Places], scene: Scene, fps: float, settings: WholeSettings) -> Manner:
    """Return how points move."""
    speed = FASTEST * scene.span / fps
    drift = find_drift(
        places, within=0.3 * scene.thickness, longest=2.0 * speed,
        lag=max(1, round(_STOOD_S * fps)),
    )  # fmt: skip
    axes = [scene.forward, scene.up]
    if scene.geometry.n_coordinates == 3:
        axes.insert(1, np.cross(scene.up, scene.forward))
    clicks = np.stack([x for here in scene.anchors.values() for x in here.values()])
    ground = -np.inf if scene.is_flat else float((clicks @ scene.up).min())
    return Manner(
        settings.acceleration * scene.span / fps**2, settings.jerk * scene.span / fps**3, speed,
        drift, np.stack(axes), ground, scene.span, scene.thickness,
    )  # fmt: skip


def find_places(
    found: Sequence[Sequence[np.ndarray]],
    scene: Scene,
    settings: WholeSettings,
    *,
    judge: Judge,
) -> list[Places]:
    """Return the places of every frame."""
    if scene.lead is not None:
        return scene.lead.places(found, settings.places)
    if scene.volume is None:
        return [_flat_places(rows[0], scene.distal[0]) for rows in found]
    return pairing(scene, settings, judge=judge).places(found)


def pairing(scene: Scene, settings: WholeSettings, *, judge: Judge) -> Pairing:
    """Return what makes places of the candidates of several views."""
    if scene.volume is None:
        raise ValueError("places need several views")
    return Pairing(
        scene.geometry.table, scene.volume, tolerance_px=0.8 * scene.thickness_px, judge=judge,
        apart=scene.thickness, most=settings.places,
    )  # fmt: skip


def seen_elsewhere(seen: np.ndarray, own: np.ndarray) -> np.ndarray:
    """Return to what share places are seen by other views than those that track a point.

    Two views make a place, and any two do. But where a view that tracks the point shows
    nothing, and one that tracks others does, it is likelier one of those: a paw that is hidden
    leaves its point free to follow the paw of the other side.

    Parameters
    ----------
    seen : ndarray, shape (k, V)
        How much each view shows a paw there, 0 to 1.
    own : ndarray of bool, shape (P, V)
        Which view tracks which point.

    Returns
    -------
    ndarray, shape (P, k)
        From 0, seen as well by its own views as by all, to 1, by others alone. Two views are
        enough; where one tracks the point, that one.
    """
    most = np.minimum(own.sum(axis=1), 2.0)[:, None]
    missed = np.maximum(most - own @ seen.T, 0.0)
    missed = missed - np.maximum(most - seen.sum(axis=1), 0.0)
    return np.asarray(missed / np.maximum(most, 1.0))


def _flat_places(rows: np.ndarray, distal: tuple[float, float]) -> Places:
    """Return the candidates of a single view as places."""
    return Places(rows[:, :2].astype(float), 1.5 * (1.0 - worth(rows, distal)))


def _start_prior(
    pieces: Sequence[Tracklet], usual: Sequence[np.ndarray], fixed: Fixed, scene: Scene
) -> np.ndarray:
    """Return the cost (P, pieces) of being far from where a point is before all tracking.

    ``usual`` has for each point where those of its kind are along forward, (n,), or nothing.
    """
    cost = np.zeros((len(usual), len(pieces)))
    if not pieces:
        return cost
    clicked = {
        p: np.mean([h[p] for h in fixed.values() if p in h], axis=0)
        for p in sorted({p for here in fixed.values() for p in here})
    }
    across = scene.across
    wanders = _WANDERS if len(clicked) < len(usual) else 1.0
    frame, at, first = joined(pieces)
    along = at @ scene.forward
    for p, expected in enumerate(usual):
        if len(expected):
            far = np.maximum(np.abs(along - expected[frame]) / scene.span - 0.33, 0.0) / 0.1
            cost[p] += 0.5 * np.add.reduceat(np.minimum(far**2, 6.0), first)
        if across is not None and p in clicked:
            aside = aside_cost((at - clicked[p]) @ across, wanders * scene.span)
            cost[p] += np.add.reduceat(aside, first)
    return cost


def where_kinds_are(
    places: Sequence[Places], fixed: Fixed, scene: Scene, *, kinds: Sequence[str], frames: int
) -> list[np.ndarray]:
    """Return where the points of each point's kind are along forward, before all tracking.

    That is where they were clicked, moved as the middle of all places, followed over some
    frames, has moved since: an animal may run through the picture. Where front and hind paws
    were clicked beside each other, it is where the foremost and the hindmost quarter of all
    places begin.

    Returns
    -------
    list of ndarray, shape (n,)
        One for each point, empty for a kind of which nothing is known.
    """
    n = len(places)
    good = [place.at[place.cost < _GOOD] @ scene.forward for place in places]
    middle = np.array([median(one) if len(one) else np.nan for one in good])
    known = np.flatnonzero(np.isfinite(middle))
    if len(known):
        middle = np.interp(np.arange(n), known, middle[known])
        middle = uniform_filter1d(middle, min(frames, n), mode="nearest")
    else:
        middle = np.zeros(n)
    since = [
        (kinds[p], float(x @ scene.forward) - middle[t]) for t, h in fixed.items()
        for p, x in h.items()
    ]  # fmt: skip
    mean = {
        kind: float(np.mean([at for other, at in since if other == kind]))
        for kind in {kind for kind, _ in since}
    }
    told = {kind: middle + at for kind, at in mean.items() if kind != "other"}
    beside = {"front", "hind"} <= set(mean) and mean["front"] - mean["hind"] < (
        _TOLD_APART * scene.span
    )
    if beside and len(known):
        away = np.concatenate([one - at for one, at in zip(good, middle, strict=True)])
        told = {
            kind: middle + np.quantile(away, share)
            for kind, share in (("front", 0.75), ("hind", 0.25))
        }
    return [told.get(kind, np.empty(0)) for kind in kinds]
