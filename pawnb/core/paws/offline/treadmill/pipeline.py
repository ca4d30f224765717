"""Deciding over the whole recording: paths, gaps and the stride, each from the others."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pawnb.core.paws.layout import Layout
from pawnb.core.paws.offline.association.network_flow.contralateral import (
    share_seen,
    side_told,
    with_strangers,
)
from pawnb.core.paws.offline.association.network_flow.lateral_prior import Beside, learn_beside
from pawnb.core.paws.offline.association.network_flow.tracklet_association import (
    PathChoice,
    find_places,
)
from pawnb.core.paws.offline.detection.colour.label_offsets import learn_offsets
from pawnb.core.paws.offline.detection.colour.likelihood import Judge, score_at_clicks
from pawnb.core.paws.offline.detection.colour.observations import (
    Sights,
    read_sights,
    tracked_points,
)
from pawnb.core.paws.offline.gap_closing.gap_closing import Bridged, Known, bridge_gaps
from pawnb.core.paws.offline.gap_closing.rejection import without_hops
from pawnb.core.paws.offline.scene.motion_model import Manner
from pawnb.core.paws.offline.scene.treadmill import Scene, unclicked_kinds
from pawnb.core.paws.offline.settings import WholeSettings
from pawnb.core.paws.offline.smoothing.association_odds import separations
from pawnb.core.paws.offline.smoothing.forward_backward_distance import left_out, passes_apart
from pawnb.core.paws.offline.smoothing.refinement import Refined, Refinement, deviations, refine
from pawnb.core.paws.offline.stride.cycle import learn_cycle
from pawnb.core.paws.offline.stride.duty_factor import Rhythm, learn_rhythm
from pawnb.core.paws.offline.stride.stance import learn_lift
from pawnb.core.paws.offline.stride.swing import Swings, learn_swings

_BELIEVED = 0.25
"""Standard deviation, in thicknesses, at which a track is half believed."""
_LEARNT_FROM = 0.3
"""The same for learning the stride and its swings from it."""
_RISING_S = 0.012
"""Time, s, after lift-off in which a paw goes on as it began."""
_STATED = 0.7
"""Standard deviations of certain places are stated so much smaller than what is reckoned with while
neighbouring frames may still err alike: so 93 to 97 % of the truth lie within 95 % limits, hidden
places among them, in rendered scenes. Cameras on one side tell depth less well than they reckon."""
_ONE_MORE = 1
"""Looks taken besides where tracks still change: a paw was told while another, for which it was
mistaken, was not yet where it is now."""
_CHANGES, _CHANGED_FRAMES = 2.0, 5
"""Tracks change where they go so many thicknesses elsewhere in so many frames."""
_SAME = 1.2
"""A place that says that a point is so many thicknesses from where it was placed is another's."""
_LEAST_SEEN = 0.3
"""Strangers that are seen as paws of their own in fewer frames are none."""
_LEAST_SEEN_ASIDE = 0.1
"""The same where depth tells that they are on the other side."""


@dataclass(frozen=True)
class Told:
    """Clicks from which it is learnt where the tracked points lie on the paws.

    Parameters
    ----------
    clicks : ndarray, shape (frames, P, V, 2)
        Clicks, px, NaN where there is none, in the order of ``found``.
    found : mapping
        Clicked frame to the candidates of every view.
    """

    clicks: np.ndarray
    found: Mapping[int, Sequence[np.ndarray]]


def decide(
    found: Sequence[Sequence[np.ndarray]],
    fixed: Mapping[int, Mapping[int, np.ndarray]],
    certain: np.ndarray,
    *,
    scene: Scene,
    layout: Layout,
    fps: float,
    settings: WholeSettings,
    told: Told | None = None,
) -> Refined:
    """Decide where every point was in every frame.

    Where a view shows paws of the other side that nobody clicked, they are followed too, as
    strangers, lest they be taken for the points of their kind. Paths are chosen among
    certain pieces and the gaps between them bridged; the stride is learnt from the tracks
    that this gives, and both are done again with it.

    Parameters
    ----------
    found : sequence
        Candidates of every frame and view.
    fixed : mapping
        Frame to point number to position, certain.
    certain : ndarray, shape (n, P, V, 2)
        Image positions placed by hand, NaN elsewhere.
    scene : Scene
        What the clicks say.
    layout : Layout
        Which point is tracked in which view.
    fps : float
        Frames per second.
    settings : WholeSettings
        The settings.
    told : Told, optional
        Clicks that say where on a paw its point is; default those of ``certain``.

    Returns
    -------
    Refined
        The tracks.
    """
    n_points = len(layout.kinds)
    if told is None:
        clicked = sorted(np.flatnonzero(np.isfinite(certain[..., 0]).any(axis=(1, 2))).tolist())
        told = Told(certain[clicked], {t: found[t] for t in clicked})
    extra, left_out = unclicked_kinds(layout.kinds), True
    while left_out:
        ready = _prepare(found, certain, told, scene=scene, layout=layout, extra=extra)
        paths = _paths(found, fixed, ready, scene=scene, fps=fps, settings=settings)
        first = paths.first()
        # a stranger without a paw of its own would share that of its kind
        share = share_seen(first, fixed, scene, body=paths.body(first), kinds=ready.kinds)
        least = _LEAST_SEEN if side_told(scene) is None else _LEAST_SEEN_ASIDE
        left_out = bool((share < least).any())
        extra = [kind for kind, seen in zip(extra, share, strict=True) if seen >= least]
    result = _settled(first, fixed, paths, ready, scene=scene, fps=fps, settings=settings)
    return Refined(
        result.x[:, :n_points], result.sd[:, :n_points], result.measured[:, :n_points],
        result.quality[:, :n_points], result.revision[:, :n_points],
        result.separation[:, :n_points], result.apart[:, :n_points],
    )  # fmt: skip


@dataclass(frozen=True)
class _Ready:
    """What is known before paths are chosen; strangers come after the clicked points."""

    kinds: list[str]
    certain: np.ndarray  # (n, P + S, V, 2)
    own: np.ndarray  # (P + S, V)
    sights: Sights
    judge: Judge
    unsure: np.ndarray
    one_sided: bool  # paws of the other side were not clicked


def _prepare(
    found: Sequence[Sequence[np.ndarray]],
    certain: np.ndarray,
    told: Told,
    *,
    scene: Scene,
    layout: Layout,
    extra: Sequence[str],
) -> _Ready:
    """Learn from the clicks what candidates say of points and strangers of the kinds ``extra``."""
    thickness_px, facing, distal = scene.thickness_px, layout.facing, scene.distal
    kinds = [*layout.kinds, *extra]
    room = ((0, 0), (0, len(extra)), (0, 0), (0, 0))
    certain = np.pad(certain, room, constant_values=np.nan)
    clicks = np.pad(told.clicks, room, constant_values=np.nan)
    # a view from below shows middles of paws, the others their ends
    below = np.arange(len(facing)) == (-1 if scene.lead is None else scene.lead.view)
    kinds_of_view = [
        learn_offsets(
            np.where(alike[:, None], clicks, np.nan), told.found, thickness_px=thickness_px,
            facing=facing, distal=distal, kinds=kinds,
        )
        for alike in (~below, below)
    ]  # fmt: skip
    offsets = [kinds_of_view[int(one)] for one in below]
    judge = Judge(distal, thickness_px)
    if scene.geometry.coefs is not None and scene.lead is None and not scene.is_learnt:
        # the curves were learnt from views from the side that agree in space
        judge = replace(judge, score=score_at_clicks(clicks, told.found, judge))
    return _Ready(
        kinds, certain, with_strangers(layout.tracked, layout.kinds, extra),
        read_sights(found, offsets, facing=facing, judge=judge), judge,
        np.max([one.unsure for one in offsets], axis=0), bool(unclicked_kinds(layout.kinds)),
    )  # fmt: skip


def _paths(
    found: Sequence[Sequence[np.ndarray]],
    fixed: Mapping[int, Mapping[int, np.ndarray]],
    ready: _Ready,
    *,
    scene: Scene,
    fps: float,
    settings: WholeSettings,
) -> PathChoice:
    """Return the pieces of path, to be chosen from."""
    meet = fixed
    if scene.lead is None:
        meet = {
            t: _meetings(
                here, found[t], ready.sights.only(t), scene=scene, settings=settings,
                judge=ready.judge,
            )
            for t, here in fixed.items()
        }  # fmt: skip
    return PathChoice(
        found, meet, scene, fps=fps, settings=settings, kinds=ready.kinds, judge=ready.judge,
        own=ready.own,
    )  # fmt: skip


def _settled(
    first: np.ndarray,
    fixed: Mapping[int, Mapping[int, np.ndarray]],
    paths: PathChoice,
    ready: _Ready,
    *,
    scene: Scene,
    fps: float,
    settings: WholeSettings,
) -> Refined:
    """Bridge the gaps of paths and learn the stride, then do all of it again with the stride."""
    what = Refinement(
        scene.geometry, scene.thickness_px, scene.thickness, paths.manner.jerk, ready.own,
        ready.unsure,
    )  # fmt: skip
    by_hand = np.isfinite(ready.certain[..., 0]).any(axis=-1)
    strides = (settings.shortest_stride_s * fps, settings.longest_stride_s * fps)

    def settle(known: Known) -> tuple[Refined, Bridged]:
        bridged = bridge_gaps(
            known, ready.sights, geometry=scene.geometry, thickness_px=scene.thickness_px,
            own=ready.own, manner=paths.manner,
        )  # fmt: skip
        refined = refine(
            known.chosen, ready.sights, bridged, certain=ready.certain, what=what,
            cycle=known.cycle, beside=_beside(known.chosen, paths, ready), swings=known.swings,
        )  # fmt: skip
        return refined, bridged

    def tracked(places: np.ndarray) -> np.ndarray:
        return _tracked(places, fixed, ready.sights, paths.manner, scene)

    def lift() -> np.ndarray | None:
        if bridged.ground is None:
            return None
        return learn_lift(
            bridged.ground, result.x, np.isfinite(result.measured[..., 0]).any(axis=-1),
            lifts=bridged.lifts, frames=max(1, round(_RISING_S * fps)),
        )  # fmt: skip

    result, bridged = settle(Known(tracked(first), by_hand))
    unaided = before = result.x
    for look in range(settings.looks + _ONE_MORE):
        if look >= settings.looks and not _changed(result.x, before, scene.thickness):
            break
        before = result.x
        sd = result.sd.mean(axis=-1) / scene.thickness
        rhythm = learn_rhythm(bridged.stances, ready.kinds)
        stances, lost = without_hops(bridged.stances, bridged.is_open, rhythm)
        bridged = replace(bridged, stances=stances)
        cycle = learn_cycle(
            result.x, paths.body(result.x), axes=paths.manner.axes, frames=strides,
            noise=0.25 * scene.thickness,
            trust=np.where(lost, 0.0, 1.0 / (1.0 + (sd / _LEARNT_FROM) ** 2)),
        )  # fmt: skip
        swings = _swings(result, bridged, rhythm, ready, lost, scene.thickness, fps=fps)
        # a recording of two strides tells a rhythm, but no cycle
        if cycle is None and swings is None:
            break
        trust = 1.0 / (1.0 + (sd / _BELIEVED) ** 2)
        places = tracked(first if cycle is None else paths.again(cycle))
        known = Known(places, by_hand, result.x, trust, cycle, lift(), rhythm, swings)
        result, bridged = settle(known)
        result.revision = np.linalg.norm(result.x - unaided, axis=-1)
    result.sd = _stated(result.sd, bridged.is_open, one_sided=ready.one_sided)
    if result.equations is not None:
        result.apart = passes_apart(result.equations)
        result.separation = separations(
            result.measured, left_out(result.x, result.equations), ready.sights,
            against=bridged.against, sigma=deviations(ready.sights.quality, what),
            geometry=scene.geometry, thickness_px=scene.thickness_px,
        )  # fmt: skip
    return result


def _changed(x: np.ndarray, before: np.ndarray, thickness: float) -> bool:
    """Tell whether tracks (n, P, d) go elsewhere than in the look before."""
    far = np.linalg.norm(x - before, axis=-1) > _CHANGES * thickness
    return bool((far.sum(axis=0) >= _CHANGED_FRAMES).any())


def _swings(
    result: Refined,
    bridged: Bridged,
    rhythm: Rhythm | None,
    ready: _Ready,
    lost: np.ndarray,
    thickness: float,
    *,
    fps: float,
) -> Swings | None:
    """Return where points swing; None without a rhythm, or where no view shows heights.

    Frames (n, P) in which points were ``lost`` tell nothing.
    """
    if rhythm is None or bridged.ground is None or np.isnan(bridged.ground.height).all():
        return None
    seen = (np.isfinite(result.measured[..., 0]) & ready.own).any(axis=-1) & ~lost
    # arcs go forward and up: that a single view tells no depth takes nothing from them
    ahead = bridged.ground.manner.axes[[0, -1]]
    sd = np.sqrt(result.sd**2 @ (ahead**2).T).mean(axis=-1) / thickness
    return learn_swings(
        result.x, seen / (1.0 + (sd / _LEARNT_FROM) ** 2), bridged.stances,
        certain=~bridged.is_open, ground=bridged.ground, rhythm=rhythm, kinds=ready.kinds, fps=fps,
    )  # fmt: skip


def _stated(sd: np.ndarray, is_open: np.ndarray, *, one_sided: bool) -> np.ndarray:
    """Return the standard deviations (n, P, d) that are stated, given where places are told."""
    certain = np.zeros_like(is_open) if one_sided else ~is_open
    return np.where(certain[..., None], _STATED * sd, sd)


def _beside(chosen: np.ndarray, paths: PathChoice, ready: _Ready) -> Beside | None:
    """Return where points usually are to the side, if only one side of the animal was clicked."""
    across = side_told(paths.scene) if ready.one_sided else None
    if across is None:
        return None
    return learn_beside(chosen, paths.body(chosen), across, span=paths.scene.span)


def _tracked(
    places: np.ndarray,
    fixed: Mapping[int, Mapping[int, np.ndarray]],
    sights: Sights,
    manner: Manner,
    scene: Scene,
) -> np.ndarray:
    """Return where the tracked points are of chosen places (n, P, d)."""
    view = None
    if scene.lead is not None:
        places = scene.lead.lift(places, sights, manner.acceleration)
        view = scene.lead.view
    moved = tracked_points(
        places, sights, geometry=scene.geometry, thickness_px=scene.thickness_px, view=view
    )
    for t, here in fixed.items():
        for p, at in here.items():
            moved[t, p] = at
    return moved


def _meetings(
    here: Mapping[int, np.ndarray],
    found: Sequence[np.ndarray],
    sights: Sights,
    *,
    scene: Scene,
    settings: WholeSettings,
    judge: Judge,
) -> dict[int, np.ndarray]:
    """Return where the candidates of placed points meet, in one frame: paths go through there.

    A click in the middle of a long foot is farther from its end than paws are apart. Of the
    places that say that the point is where it was placed, its toes and its heel, the one that
    looks best is taken; without any, the point itself.
    """
    places = find_places([found], scene, settings, judge=judge)[0]
    n_points = sights.at.shape[1]
    meet = dict(here)
    price = dict.fromkeys(here, np.inf)
    for place, cost in zip(places.at, places.cost, strict=True):
        said = tracked_points(
            np.tile(place, (1, n_points, 1)), sights, geometry=scene.geometry,
            thickness_px=scene.thickness_px,
        )[0]  # fmt: skip
        for p, at in here.items():
            away = float(np.linalg.norm(said[p] - at)) / scene.thickness
            if away < _SAME and cost + away < price[p]:
                meet[p], price[p] = place, cost + away
    return meet
