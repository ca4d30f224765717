"""One direction through a recording: each frame from the one before, with what it leaves open.

Every frame makes a new state of the one before; none changes what it is given.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

import numpy as np

from pawnb.arrays import BoolArray, FloatArray
from pawnb.core.frame_checkpoint import KeptFrames, Record
from pawnb.core.parallel import Threads
from pawnb.core.pose.fit.candidates.candidate_sets import LegCandidates, only_candidate, recalled
from pawnb.core.pose.fit.candidates.leg_candidates import (
    fit_leg,
    limb_candidates,
    with_candidates,
)
from pawnb.core.pose.fit.candidates.parameters import CANDIDATES
from pawnb.core.pose.fit.candidates.viterbi import ViterbiTrellis, extend_trellis
from pawnb.core.pose.fit.candidates.weighing import legs_cross, side_energy
from pawnb.core.pose.fit.fitter import FrameFitter
from pawnb.core.pose.fit.learning.anatomy import about
from pawnb.core.pose.fit.observation import Box, evidence_of, narrowed, observe
from pawnb.core.pose.fit.rendering.gauss_newton_kernels import ImageEvidence, Prior, prior_cost
from pawnb.core.pose.fit.sequence.body_search import find_body
from pawnb.core.pose.fit.sequence.expectation import expectation, fit_expected, usual_anatomy
from pawnb.core.pose.fit.sequence.parameters import SEQUENCE
from pawnb.core.pose.fit.sequence.state import Followed, FollowState
from pawnb.core.pose.fit.support import body_support, count_unexplained, leg_supports
from pawnb.core.video.views import Frame


def follow(
    fitter: FrameFitter,
    pose: FloatArray,
    frames: Iterable[Frame],
    *,
    done: Callable[[], None] | None = None,
    kept: KeptFrames | None = None,
    way: str = "",
) -> Followed:
    """Follow the animal through frames until they end or it leaves.

    What is found in a frame is kept under the name of this ``way``, and is not looked for
    where an earlier run has kept it.

    Parameters
    ----------
    fitter : FrameFitter
        What poses are fitted with.
    pose : ndarray, shape (n_parameters,)
        The pose in the frame before the first.
    frames : iterable of Frame
        Frames in the order in which they are followed.
    done : callable, optional
        Called after each frame.
    kept : KeptFrames, optional
        Where frames are kept, and taken from where they are there.
    way : str
        Which way this is, in what is kept.

    Returns
    -------
    Followed
        What was found.
    """
    # numpy's own part is small: the compiled loops of two legs run side by side
    with Threads(len(fitter.index.sides), thread_name_prefix="pawnb-legs") as threads:
        return Follower(fitter, threads).run(
            pose, frames, done=done, kept=kept or KeptFrames(), way=way
        )


@dataclass(frozen=True)
class Follower:
    """Follows the animal from frame to frame.

    Parameters
    ----------
    fitter : FrameFitter
        What poses are fitted with.
    threads : Threads
        Where legs are looked for.
    """

    fitter: FrameFitter
    threads: Threads

    def run(
        self,
        pose: FloatArray,
        frames: Iterable[Frame],
        *,
        done: Callable[[], None] | None,
        kept: KeptFrames,
        way: str,
    ) -> Followed:
        """Follow through frames until they end or the animal leaves.

        Parameters
        ----------
        pose, frames, done, kept, way
            As for :func:`follow`.

        Returns
        -------
        Followed
            What was found.
        """
        state = FollowState.begin(self.fitter, pose)
        found: list[LegCandidates] = []
        for frame in frames:
            record = kept.recall(way, frame.index)
            if record is not None:
                state = self.again(state, record, frame)
            elif (after := self.advance(state, frame)) is not None:
                kept.keep(way, frame.index, after.record())
                state = after
            else:
                break
            found += state.last
            if done is not None:
                done()
        # the last frames were followed in case the body came back
        found = found[: len(found) - state.lost]
        return Followed(self.fitter, tuple(found), state.middle, state.jump_px)

    def again(self, state: FollowState, record: Record, frame: Frame) -> FollowState:
        """Return the state after a frame that an earlier run has fitted.

        Parameters
        ----------
        state : FollowState
            Before the frame.
        record : mapping
            What was kept of the state after it.
        frame : Frame
            The frame.

        Returns
        -------
        FollowState
            As if it had been fitted.
        """
        image = self.fitter.evidence.pixels(frame, tuple(record["candidates"]["box"]))
        candidates = recalled(self.fitter, frame.index, record["candidates"], image=image)
        trellises = state.trellises
        if self.fitter.settings.choose_path:
            trellises = self._extended(state, candidates)
        return state.recalled(record, candidates, trellises)

    def advance(self, state: FollowState, frame: Frame) -> FollowState | None:
        """Return the state after the next frame; None where the animal is no longer there."""
        fitter = self.fitter
        expected = state.pose + state.velocity
        evidence = fitter.evidence
        if not (0 <= expected[0] < evidence.width and 0 <= expected[1] < evidence.height):
            return None
        expected, image_evidence, image, box = self._observed(frame, expected)
        anatomy = usual_anatomy(fitter, state.middle)
        prior = expectation(fitter, anatomy, expected)
        pose = fit_expected(fitter, expected, image_evidence=image_evidence, prior=prior)
        is_lost = body_support(fitter, pose, image_evidence) < SEQUENCE.body_lost
        if is_lost and state.lost >= SEQUENCE.lost_frames:
            return None
        candidates = only_candidate(fitter, frame.index, pose, image=image, box=box)
        if fitter.settings.choose_path:
            doubted, usual = self._doubted(state, candidates, image_evidence, anatomy)
            candidates = self._with_rivals(state, candidates, doubted, image_evidence, anatomy)
            trellises = self._extended(state, candidates)
            candidates, pose = self._decided(candidates, trellises, image_evidence, prior)
            state = replace(state, usual=usual, trellises=trellises)
            state = self._with_jump(state, expected, pose)
        state = replace(state, lost=state.lost + 1 if is_lost else 0)
        return self._moved_on(state, candidates, pose)

    def _observed(
        self, frame: Frame, expected: FloatArray
    ) -> tuple[FloatArray, ImageEvidence, FloatArray, Box]:
        """Return the expected pose, moved onto the body, and what the frame shows there."""
        image_evidence, image, box = observe(self.fitter, frame, expected, margin=np.inf)
        found = find_body(self.fitter, expected, image_evidence)
        if found is expected:  # what is left out of the light is the same
            return expected, narrowed(self.fitter, image_evidence, expected), image, box
        return found, evidence_of(self.fitter, found, image=image, box=box), image, box

    def _with_rivals(
        self,
        before: FollowState,
        candidates: LegCandidates,
        doubted: BoolArray,
        image_evidence: ImageEvidence,
        anatomy: Prior,
    ) -> LegCandidates:
        """Return a frame with candidates of doubted legs, and with those of the frame before."""
        fitter, pose = self.fitter, candidates.pose

        def search(leg: int) -> list[np.ndarray]:
            known = before.last[-1].alternatives[leg] if before.last else ()
            found = [
                fit_leg(
                    fitter, pose, leg, guess=numbers, image_evidence=image_evidence,
                    prior=anatomy, rounds=SEQUENCE.rounds_alternative,
                )
                for numbers in known
            ]  # fmt: skip
            if doubted[leg]:
                found += limb_candidates(
                    fitter, pose, leg, image_evidence=image_evidence, prior=anatomy
                )
            return found

        # each thread takes the next leg; those that take long come first
        order = np.argsort(~doubted, kind="stable").tolist()
        found = dict(zip(order, self.threads.map(search, order), strict=True))
        extra = {leg: found[leg] for leg in sorted(found) if found[leg]}
        if not extra:
            return candidates
        return with_candidates(
            fitter, candidates, extra, image_evidence=image_evidence, prior=anatomy
        )

    def _doubted(
        self,
        before: FollowState,
        candidates: LegCandidates,
        image_evidence: ImageEvidence,
        anatomy: Prior,
    ) -> tuple[BoolArray, FloatArray]:
        """Return which legs may be elsewhere, and how much is usually left over."""
        fitter = self.fitter
        support = leg_supports(fitter, candidates.pose, image_evidence)
        doubted = ~((support[:, 0] >= SEQUENCE.leg_lost) & (support[:, 1] >= SEQUENCE.tip_lost))
        doubted |= before.n_frames < SEQUENCE.first_frames
        left_over = count_unexplained(fitter, candidates.pose, image_evidence)
        usual = np.minimum(before.usual * SEQUENCE.usual_grows + 1.0, left_over)
        on_right = (fitter.layout.side > 0).astype(int)
        doubted |= (left_over > usual + SEQUENCE.unexplained_share * fitter.leg_area)[on_right]
        joints = [j[0] for j in candidates.joints]
        for legs in fitter.index.sides:
            for a, b in itertools.pairwise(legs):
                gap = np.hypot(*(joints[a] - joints[b]).T)
                close = np.nanmin(gap[-3:]) < SEQUENCE.close * CANDIDATES.same_px
                if close or legs_cross(fitter, (a, joints[a]), (b, joints[b])):
                    doubted[[a, b]] = True
        for leg, numbers in enumerate(fitter.index.numbers):
            if prior_cost(candidates.pose, anatomy, numbers) > SEQUENCE.one_direction_unlikely:
                doubted[leg] = True
        return doubted, usual

    def _extended(
        self, before: FollowState, candidates: LegCandidates
    ) -> tuple[ViterbiTrellis, ...]:
        """Return the paths of each side to a frame, the second by the best of the first."""
        share = self.fitter.settings.evidence_share
        out, which = [], dict.fromkeys(range(len(candidates.legs)), 0)
        for legs, trellis in zip(self.fitter.index.sides, before.trellises, strict=True):
            others = {leg: k for leg, k in which.items() if leg not in legs}
            energy = side_energy(candidates, legs, share, others=others)
            joints = tuple(candidates.joints[leg] for leg in legs)
            out.append(extend_trellis(trellis, energy, joints, jump_px=before.jump_px))
            which.update(zip(legs, out[-1].best(), strict=True))
        return tuple(out)

    def _decided(
        self,
        candidates: LegCandidates,
        trellises: tuple[ViterbiTrellis, ...],
        image_evidence: ImageEvidence,
        prior: Prior,
    ) -> tuple[LegCandidates, FloatArray]:
        """Return the frame with its rivals, and the pose that is best by what is known so far."""
        fitter, pose = self.fitter, candidates.pose.copy()
        changed, rivals = False, {}
        for legs, trellis in zip(fitter.index.sides, trellises, strict=True):
            for leg, which, cost in zip(legs, trellis.best(), trellis.marginals(), strict=True):
                near = cost < cost[which] + SEQUENCE.one_direction_rival
                near[which] = False
                rivals[leg] = candidates.legs[leg][near]
                if which:
                    pose[fitter.index.numbers[leg]] = candidates.legs[leg][which]
                    changed = True
        if changed:
            sd = np.full(fitter.index.n, np.inf)
            sd[fitter.index.angles] = np.radians(fitter.settings.angle_step_deg)
            pose, _ = fitter.fit(
                pose, image_evidence, about(prior, pose, sd), rounds=SEQUENCE.rounds_decided
            )
        return candidates.with_alternatives(rivals), pose

    def _with_jump(self, state: FollowState, expected: FloatArray, pose: FloatArray) -> FollowState:
        """Let legs jump as far as they are seen to stray from their expected places."""
        fitter = self.fitter
        square = ((fitter.joints(pose) - fitter.joints(expected)) ** 2).sum(axis=-1)
        far = float(np.median(np.sqrt(np.nanmean(square, axis=1))))
        astray = (*state.astray, far)[-SEQUENCE.jump_frames :]
        usual = SEQUENCE.jump_of_median * float(np.median(astray))
        return replace(state, astray=astray, jump_px=max(fitter.settings.jump_px, usual))

    def _moved_on(
        self, state: FollowState, candidates: LegCandidates, pose: FloatArray
    ) -> FollowState:
        """Return the state after a frame with a pose, and how that moves."""
        fitter, lengths = self.fitter, self.fitter.index.lengths
        moved = pose - state.pose
        apart = np.abs(fitter.joints(pose) - fitter.joints(state.pose))
        far = apart.reshape(len(fitter.index.numbers), -1)
        for leg, numbers in enumerate(fitter.index.numbers):
            if np.nanmax(far[leg]) > SEQUENCE.leap_far * SEQUENCE.leap_px:
                moved[numbers] = 0.0
        moved[lengths] = 0.0
        middle = state.middle + SEQUENCE.learn_length * (pose[lengths] - state.middle)
        return replace(
            state, pose=pose, velocity=SEQUENCE.keep_velocity * moved, middle=middle,
            last=(candidates,), n_frames=state.n_frames + 1,
        )  # fmt: skip
