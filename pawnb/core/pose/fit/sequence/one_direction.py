"""One direction through a recording: each frame from the one before, with what it leaves open."""

from __future__ import annotations

import itertools
from collections import ChainMap
from collections.abc import Callable, Iterable

import numpy as np

from pawnb.arrays import BoolArray, FloatArray
from pawnb.core.frame_checkpoint import KeptFrames, Record
from pawnb.core.parallel import Threads
from pawnb.core.pose.fit.candidates.candidate_sets import (
    LegCandidates,
    only_choice,
    recalled,
)
from pawnb.core.pose.fit.candidates.leg_candidates import (
    add_candidates,
    fit_leg,
    legs_cross,
    limb_candidates,
    side_energy,
    sides_of,
)
from pawnb.core.pose.fit.candidates.parameters import CANDIDATES
from pawnb.core.pose.fit.candidates.viterbi import ViterbiTrellis
from pawnb.core.pose.fit.fitter import FrameFitter
from pawnb.core.pose.fit.learning.anatomy import about
from pawnb.core.pose.fit.observation import evidence_of, narrowed, observe
from pawnb.core.pose.fit.rendering.blur import blurred
from pawnb.core.pose.fit.rendering.gauss_newton_kernels import ImageEvidence, Prior, prior_cost
from pawnb.core.pose.fit.sequence.body_search import find_body
from pawnb.core.pose.fit.sequence.parameters import SEQUENCE
from pawnb.core.pose.fit.support import body_support, count_unexplained, leg_supports
from pawnb.core.video.views import Frame

_STATE = ("pose", "velocity", "middle", "jump_px", "_usual", "_lost", "_astray")
"""All that the next frame needs to know of those before, besides what each leaves open."""


class Follower:
    """Follows the animal from frame to frame.

    Parameters
    ----------
    fitter : FrameFitter
        Fits single frames.
    pose : ndarray, shape (n_parameters,)
        The pose in the frame before the first.
    """

    def __init__(self, fitter: FrameFitter, pose: FloatArray) -> None:
        self.fitter = fitter
        self.pose = pose
        self.velocity = np.zeros_like(pose)
        self.middle = pose[fitter.index.lengths].copy()
        self.kept: list[LegCandidates] = []
        self.sides = sides_of(fitter.layout.side)
        self.trellises = [ViterbiTrellis(fitter.settings.jump_px) for _ in self.sides]
        self._usual = np.full(2, np.inf)
        # numpy's own part is small: the compiled loops of two legs run side by side
        self._pool = Threads(len(self.sides), thread_name_prefix="pawnb-legs")
        self._lost = 0
        self._astray: list[float] = []
        self.jump_px = fitter.settings.jump_px

    def run(
        self,
        frames: Iterable[Frame],
        *,
        done: Callable[[], None] | None = None,
        kept: KeptFrames | None = None,
        way: str = "",
    ) -> list[LegCandidates]:
        """Follow through frames until they end or the animal leaves; return what was found.

        What is found in a frame is kept under the name of this ``way``, and is not looked for
        where an earlier run has kept it.

        Parameters
        ----------
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
        list of Choices
            One a frame.
        """
        kept = kept or KeptFrames()
        with self._pool:
            for frame in frames:
                record = kept.recall(way, frame.index)
                if record is not None:
                    self._go_on(frame, record)
                elif self.advance(frame):
                    kept.keep(way, frame.index, self._record())
                else:
                    break
                if done is not None:
                    done()
        if self._lost:  # the last frames were kept in case the body came back
            del self.kept[len(self.kept) - min(self._lost, SEQUENCE.lost_frames) :]
        return self.kept

    def advance(self, frame: Frame) -> bool:
        """Fit the next frame; False where the animal is no longer there."""
        fitter = self.fitter
        expected = self.pose + self.velocity
        evidence = fitter.evidence
        if not (0 <= expected[0] < evidence.width and 0 <= expected[1] < evidence.height):
            return False
        image_evidence, image, box = observe(fitter, frame, expected, margin=np.inf)
        found = find_body(fitter, expected, image_evidence)
        if found is expected:  # what is left out of the light is the same
            image_evidence = narrowed(fitter, image_evidence, expected)
        else:
            expected = found
            image_evidence = evidence_of(fitter, image, box, expected)
        anatomy, prior = self.priors(expected)
        pose = self.fit_from(expected, image_evidence)
        if body_support(fitter, pose, image_evidence) < SEQUENCE.body_lost:
            self._lost += 1
            if self._lost > SEQUENCE.lost_frames:
                return False
        else:
            self._lost = 0
        choices = only_choice(fitter, frame.index, pose, image=image, box=box)
        if fitter.settings.choose_path:
            self._add(choices, image_evidence, anatomy)
            pose = self._decide(choices, image_evidence, prior)
            self._learn_jump(expected, pose)
        self._move_on(pose)
        self.kept.append(choices)
        return True

    def _record(self) -> Record:
        """Return what the last frame left open, and what the next one needs to know."""
        state = {name: getattr(self, name) for name in _STATE}
        return {"choices": self.kept[-1].record(), "state": state}

    def _go_on(self, frame: Frame, record: Record) -> None:
        """Be as if the frame had been fitted, of which :meth:`_record` made this."""
        fitter, box = self.fitter, tuple(record["choices"]["box"])
        image = fitter.evidence.pixels(frame, box)
        choices = recalled(fitter, frame.index, record["choices"], image=image)
        if fitter.settings.choose_path:
            self._push(choices)
        for name in _STATE:
            setattr(self, name, record["state"][name])
        for viterbi_trellis in self.trellises:
            viterbi_trellis.jump_px = self.jump_px
        self.kept.append(choices)

    def fit_from(self, expected: FloatArray, image_evidence: ImageEvidence) -> FloatArray:
        """Return the pose near the expected one that fits best: first blurred, then sharp.

        Parameters
        ----------
        expected : ndarray
            The pose vector that is expected.
        image_evidence : ImageEvidence
            What the frame shows.

        Returns
        -------
        ndarray
            The pose vector.
        """
        fitter = self.fitter
        _, prior = self.priors(expected)
        soft = blurred(image_evidence, SEQUENCE.coarse_blur)
        pose, _ = fitter.fit(
            expected, soft, prior, blur=fitter.blur + SEQUENCE.coarse_blur, rounds=2
        )
        pose, _ = fitter.fit(pose, image_evidence, prior, rounds=5)
        return pose

    def priors(self, expected: FloatArray) -> tuple[Prior, Prior]:
        """Return the prior of anatomy alone, and with the expected pose."""
        fitter = self.fitter
        middle = fitter.anatomy.middle.copy()
        middle[fitter.index.lengths] = self.middle
        anatomy = fitter.anatomy._replace(middle=middle)
        sd = np.full(fitter.index.n, np.inf)
        sd[fitter.index.angles] = np.radians(fitter.settings.angle_step_deg)
        sd[fitter.index.lengths] = fitter.settings.foreshortening_sd
        return anatomy, about(anatomy, expected, sd)

    def _add(self, choices: LegCandidates, image_evidence: ImageEvidence, anatomy: Prior) -> None:
        """Add candidates to a frame that gives reason to doubt, and those of the frame before."""
        doubted = self._doubted(choices, image_evidence, anatomy)
        # each thread takes the next leg; those that take long come first
        waiting = iter(np.argsort(~doubted, kind="stable").tolist())

        def search(_: list[int]) -> dict[int, list[np.ndarray]]:
            found, fitter = {}, self.fitter
            for leg in waiting:
                found[leg] = self._continued(leg, choices.pose, image_evidence, anatomy)
                if doubted[leg]:
                    found[leg] += limb_candidates(
                        fitter, choices.pose, leg, image_evidence=image_evidence, prior=anatomy
                    )
            return found

        found = dict(ChainMap(*self._pool.map(search, self.sides)))
        extra = {leg: found[leg] for leg in sorted(found) if found[leg]}
        if extra:
            add_candidates(
                self.fitter, choices, extra, image_evidence=image_evidence, prior=anatomy
            )

    def _continued(
        self,
        leg: int,
        pose: FloatArray,
        image_evidence: ImageEvidence,
        anatomy: Prior,
    ) -> list[np.ndarray]:
        """Return the last frame's rivals of a leg's pose, moved with the body and fitted."""
        if not self.kept:
            return []
        return [
            fit_leg(
                self.fitter,
                pose,
                leg,
                guess=numbers,
                image_evidence=image_evidence,
                prior=anatomy,
                rounds=3,
            )
            for numbers in self.kept[-1].alternatives[leg]
        ]

    def _doubted(
        self, choices: LegCandidates, image_evidence: ImageEvidence, anatomy: Prior
    ) -> BoolArray:
        """Return which legs may be elsewhere."""
        fitter = self.fitter
        support = leg_supports(fitter, choices.pose, image_evidence)
        doubted = ~((support[:, 0] >= SEQUENCE.leg_lost) & (support[:, 1] >= SEQUENCE.tip_lost))
        doubted |= len(self.kept) < SEQUENCE.first_frames
        left_over = count_unexplained(fitter, choices.pose, image_evidence)
        usual = np.minimum(self._usual * SEQUENCE.usual_grows + 1.0, left_over)
        on_right = (fitter.layout.side > 0).astype(int)
        doubted |= (left_over > usual + SEQUENCE.unexplained_share * fitter.leg_area)[on_right]
        self._usual = usual
        joints = [j[0] for j in choices.joints]
        for legs in self.sides:
            for a, b in itertools.pairwise(legs):
                gap = np.hypot(*(joints[a] - joints[b]).T)
                close = np.nanmin(gap[-3:]) < 2 * CANDIDATES.same_px
                if close or legs_cross(fitter, (a, joints[a]), (b, joints[b])):
                    doubted[[a, b]] = True
        for leg, numbers in enumerate(fitter.index.numbers):
            if prior_cost(choices.pose, anatomy, numbers) > SEQUENCE.one_direction_unlikely:
                doubted[leg] = True
        return doubted

    def _decide(
        self, choices: LegCandidates, image_evidence: ImageEvidence, prior: Prior
    ) -> FloatArray:
        """Return the pose that is best by what is known so far."""
        fitter, pose = self.fitter, choices.pose.copy()
        changed = False
        choices.alternatives = [c[:0] for c in choices.legs]
        states = self._push(choices)
        for legs, viterbi_trellis, state in zip(self.sides, self.trellises, states, strict=True):
            for leg, which, cost in zip(legs, state, viterbi_trellis.marginals(), strict=True):
                near = cost < cost[which] + SEQUENCE.one_direction_rival
                near[which] = False
                choices.alternatives[leg] = choices.legs[leg][near]
                if which:
                    pose[fitter.index.numbers[leg]] = choices.legs[leg][which]
                    changed = True
        if changed:
            sd = np.full(fitter.index.n, np.inf)
            sd[fitter.index.angles] = np.radians(fitter.settings.angle_step_deg)
            pose, _ = fitter.fit(pose, image_evidence, about(prior, pose, sd), rounds=4)
        return pose

    def _push(self, choices: LegCandidates) -> list[tuple[int, ...]]:
        """Add a frame to the paths; return the best state of each side by what is known so far."""
        share = self.fitter.settings.evidence_share
        states, which = [], dict.fromkeys(range(len(choices.legs)), 0)
        for legs, viterbi_trellis in zip(self.sides, self.trellises, strict=True):
            others = {leg: k for leg, k in which.items() if leg not in legs}
            energy = side_energy(choices, legs, share, others=others)
            states.append(viterbi_trellis.push(energy, [choices.joints[leg] for leg in legs]))
            which.update(zip(legs, states[-1], strict=True))
        return states

    def _learn_jump(self, expected: FloatArray, pose: FloatArray) -> None:
        """Let legs jump as far as they are seen to stray from their expected places."""
        fitter = self.fitter
        square = ((fitter.joints(pose) - fitter.joints(expected)) ** 2).sum(axis=-1)
        self._astray.append(float(np.median(np.sqrt(np.nanmean(square, axis=1)))))
        self._astray = self._astray[-SEQUENCE.jump_frames :]
        usual = SEQUENCE.jump_of_median * float(np.median(self._astray))
        self.jump_px = max(fitter.settings.jump_px, usual)
        for viterbi_trellis in self.trellises:
            viterbi_trellis.jump_px = self.jump_px

    def _move_on(self, pose: FloatArray) -> None:
        """Remember the pose, and how it moves."""
        fitter = self.fitter
        moved = pose - self.pose
        far = np.abs(fitter.joints(pose) - fitter.joints(self.pose)).reshape(
            len(fitter.index.numbers), -1
        )
        for leg, numbers in enumerate(fitter.index.numbers):
            if np.nanmax(far[leg]) > 3 * SEQUENCE.leap_px:
                moved[numbers] = 0.0
        moved[fitter.index.lengths] = 0.0
        self.velocity = SEQUENCE.keep_velocity * moved
        self.middle += SEQUENCE.learn_length * (pose[fitter.index.lengths] - self.middle)
        self.pose = pose
