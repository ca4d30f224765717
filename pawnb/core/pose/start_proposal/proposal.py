"""A first pose without a click: body, heading, scale and legs from the animal's outline."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np

from pawnb.core.pose.animal import Leg, StickAnimal
from pawnb.core.pose.poses import Poses, joint_positions
from pawnb.core.pose.start_proposal.body_fit import BodyFit, fit_body
from pawnb.core.pose.start_proposal.limb_fit import (
    LegFit,
    assign_limbs,
    count_crossings,
    fit_leg,
    shared_limb,
)
from pawnb.core.pose.start_proposal.parameters import POSE_PROPOSAL
from pawnb.core.pose.start_proposal.silhouette import (
    BackgroundModel,
    LimbOutline,
    Silhouette,
    find_silhouette,
    trace_limbs,
)
from pawnb.errors import InputError


class Frames(Protocol):
    """What is asked of a reader; :class:`pawnb.core.video.views.ViewReader` has it."""

    n_frames: int

    def frame(self, index: int, /) -> Any:
        """Return a frame with ``image()``."""


@dataclass(frozen=True)
class PoseProposal:
    """A pose to start from, and how sure of it one may be.

    Parameters
    ----------
    pose : Poses
        One frame. A leg that was not found is at its natural orientation.
    sure : dict of str to float
        How sure each leg is, 0 (not found) to 1.
    notes : tuple of str
        What a person should know, in sentences.
    """

    pose: Poses
    sure: dict[str, float]
    notes: tuple[str, ...]


@dataclass(frozen=True)
class _BodyHypothesis:
    """One frame, looked at quickly, with one way round of the body."""

    frame: int
    outline: Silhouette
    body: BodyFit
    found: dict[str, LimbOutline]
    margins: dict[str, float]
    cost: float


def propose_pose(
    reader: Frames,
    animal: StickAnimal,
    background: BackgroundModel,
    *,
    frames: Sequence[int] | None = None,
    px_per_unit: float | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> PoseProposal:
    """Find the animal's pose in a frame where it is well seen.

    In each frame the outline is what differs from the background; its body is what remains
    without thin parts, and each limb is the way from a farthest point to the body. The body's
    ellipses are laid on the body both ways round; limbs are given to legs by direction, length
    and root. Front and rear are decided by how well all that fits and by the direction of travel.
    In the best frames each leg is then bent along its limb.

    Parameters
    ----------
    reader : ViewReader
        The recording.
    animal : StickAnimal
        The animal.
    background : Background
        The empty scene.
    frames : sequence of int, optional
        Frames that may be looked through; default all. At most 40 spread over them are, and
        where the best of these leaves a leg in doubt, 40 more.
    px_per_unit : float, optional
        Where the picture is calibrated; then a note says how much larger or smaller the
        animal is than its species file. The scale itself comes from the body in the picture.
    progress : callable, optional
        ``progress(done, total)``.

    Returns
    -------
    PoseProposal
        Pose, sureness of each leg, notes.

    Raises
    ------
    InputError
        If no frame shows the whole animal away from the edges of the picture.
    """
    every = sorted({int(frame) for frame in frames or range(reader.n_frames)})
    first = _spread(every, POSE_PROPOSAL.frames_most)
    hypotheses = _find_bodies(reader, animal, background, first, progress)
    if hypotheses:
        hypothesis, legs = _fit_best(animal, _with_travel(animal, hypotheses))
    if not hypotheses or min(fit.sure for fit in legs.values()) < POSE_PROPOSAL.doubtful:
        more = _spread([frame for frame in every if frame not in first], POSE_PROPOSAL.frames_most)
        hypotheses += _find_bodies(reader, animal, background, more, progress)
        if not hypotheses:
            raise InputError(
                f"no animal was found whole in {len(first) + len(more)} frames looked at: none is "
                "there, or it touches the edge of the picture; expected at least one frame with "
                "the whole animal inside. Pose the stick animal by hand."
            )
        hypothesis, legs = _fit_best(animal, _with_travel(animal, hypotheses))
    pose = _pose_of(animal, hypothesis, legs)
    sure = {name: round(fit.sure, 3) for name, fit in legs.items()}
    return PoseProposal(pose, sure, tuple(_notes(animal, hypothesis, pose, px_per_unit)))


def _find_bodies(
    reader: Frames,
    animal: StickAnimal,
    background: BackgroundModel,
    frames: Sequence[int],
    progress: Callable[[int, int], None] | None,
) -> list[_BodyHypothesis]:
    """Look at every frame; return those that show the whole animal, each way round."""
    hypotheses: list[_BodyHypothesis] = []
    for done, frame in enumerate(frames):
        outline = find_silhouette(reader.frame(frame).image(), background)
        if outline is not None and not outline.at_edge:
            hypotheses += _both_ways(animal, frame, outline)
        if progress is not None:
            progress(done + 1, len(frames))
    areas = {
        hypothesis.frame: hypothesis.outline.mask.sum() * hypothesis.outline.shrink**2
        for hypothesis in hypotheses
    }
    usual = float(np.median(list(areas.values()))) if areas else 0.0
    # others show half an animal, or something else
    least, most = POSE_PROPOSAL.area_range
    return [
        hypothesis for hypothesis in hypotheses if least < areas[hypothesis.frame] / usual < most
    ]


def _both_ways(animal: StickAnimal, frame: int, outline: Silhouette) -> list[_BodyHypothesis]:
    """Return what one frame says of either way round of the body."""
    bodies = fit_body(animal, outline)
    usual_leg = float(np.median([sum(leg.lengths) for leg in animal.legs]))
    shortest = POSE_PROPOSAL.limb_shortest * bodies[0].scale * usual_leg
    most = len(animal.legs) + POSE_PROPOSAL.limbs_more
    limbs = trace_limbs(outline, shortest=shortest, most=most)
    hypotheses = []
    for body in bodies:
        found, margins, cost = assign_limbs(animal, body, limbs)
        cost += POSE_PROPOSAL.body_misfit * body.misfit
        hypotheses.append(_BodyHypothesis(frame, outline, body, found, margins, cost))
    return hypotheses


def _spread(frames: Sequence[int], most: int) -> list[int]:
    """Return at most so many of the frames, evenly spread."""
    if len(frames) <= most:
        return list(frames)
    return [frames[int(k)] for k in np.linspace(0, len(frames) - 1, most).round()]


def _with_travel(animal: StickAnimal, hypotheses: list[_BodyHypothesis]) -> list[_BodyHypothesis]:
    """Add to the cost of each hypothesis what the direction of travel says against its heading."""
    places: dict[int, np.ndarray] = {}
    for hypothesis in hypotheses:
        v, u = np.nonzero(hypothesis.outline.core)
        places[hypothesis.frame] = hypothesis.outline.to_view(np.array([u.mean(), v.mean()]))
    frames = sorted(places)
    along = np.array([places[frame] for frame in frames])
    step = np.gradient(along, axis=0) if len(frames) > 1 else np.zeros_like(along)
    travelled = dict(zip(frames, step, strict=True))
    out, p = [], POSE_PROPOSAL
    for hypothesis in hypotheses:
        size = hypothesis.body.scale * hypothesis.outline.shrink * animal.body_length
        turn = np.radians(hypothesis.body.heading_deg)
        along_it = float(travelled[hypothesis.frame] @ [np.cos(turn), np.sin(turn)])
        forward = along_it / (p.travel_of_body * size)
        cost = hypothesis.cost - p.travel * float(np.clip(forward, -1.0, 1.0))
        out.append(replace(hypothesis, cost=cost))
    return out


def _fit_best(
    animal: StickAnimal, hypotheses: list[_BodyHypothesis]
) -> tuple[_BodyHypothesis, dict[str, LegFit]]:
    """Fit the legs in the best frames; return the one that fits best."""
    by_frame: dict[int, _BodyHypothesis] = {}
    for hypothesis in hypotheses:
        if hypothesis.frame not in by_frame or hypothesis.cost < by_frame[hypothesis.frame].cost:
            by_frame[hypothesis.frame] = hypothesis
    tried, p = [], POSE_PROPOSAL
    for hypothesis in sorted(by_frame.values(), key=lambda x: x.cost)[: p.frames_fitted]:
        legs = {leg.name: _fit_one(leg, hypothesis) for leg in animal.legs}
        places = joint_positions(animal, _pose_of(animal, hypothesis, legs))[0]
        chains = [c[np.isfinite(c[:, 0])][1:] for c in places]
        doubt = sum(1.0 - fit.sure for fit in legs.values())
        cost = hypothesis.cost + p.doubt * doubt + p.crossing * count_crossings(chains)
        tried.append((cost, hypothesis, legs))
    _, hypothesis, legs = min(tried, key=lambda t: t[0])
    return hypothesis, legs


def _fit_one(leg: Leg, hypothesis: _BodyHypothesis) -> LegFit:
    """Bend one leg along its limb; without one, along that of a leg beside it, or not at all."""
    limb, margin = hypothesis.found.get(leg.name), hypothesis.margins[leg.name]
    if limb is None:
        limb = shared_limb(leg, hypothesis.body, hypothesis.found, outline=hypothesis.outline)
        margin = 0.0
    if limb is None:
        return LegFit(np.array(leg.natural_deg)[np.array(leg.free)], 1.0, 0.0)
    return fit_leg(leg, hypothesis.body, limb, outline=hypothesis.outline, margin=margin)


def _pose_of(animal: StickAnimal, hypothesis: _BodyHypothesis, legs: dict[str, LegFit]) -> Poses:
    """Return the pose in px of the view."""
    scale = hypothesis.body.scale * hypothesis.outline.shrink
    factors = np.array([legs[leg.name].factor for leg in animal.legs for _ in leg.lengths])
    return Poses(
        frames=np.array([hypothesis.frame]),
        xy=hypothesis.outline.to_view(hypothesis.body.xy)[None],
        heading_deg=np.array([hypothesis.body.heading_deg]),
        scale=np.array([scale]),
        angles_deg=np.concatenate([legs[leg.name].angles_deg for leg in animal.legs])[None],
        lengths_px=(scale * animal.lengths * factors)[None],
    )


def _notes(
    animal: StickAnimal, body: _BodyHypothesis, pose: Poses, px_per_unit: float | None
) -> list[str]:
    """Say what a person should know."""
    notes = []
    missing = [leg.name for leg in animal.legs if leg.name not in body.found]
    if missing:
        notes.append(
            f"No limb of its own was found for {', '.join(missing)} in frame {body.frame}: look "
            "at it, pose it by hand, or say that the leg is missing."
        )
    if body.outline.others > POSE_PROPOSAL.second:
        notes.append(
            f"Frame {body.frame} shows a second thing, {100 * body.outline.others:.0f} % as large "
            "as the animal; the larger was posed. Crop the view if it is the wrong one."
        )
    if px_per_unit is not None:
        ratio = float(pose.scale[0]) / px_per_unit
        least, most = POSE_PROPOSAL.odd_scale
        if not least < ratio < most:
            notes.append(
                f"The animal is {ratio:.2f} times as large as its species file says; "
                "check the calibration or the species."
            )
    return notes
