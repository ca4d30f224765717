"""Which of the places of one frame is which paw, and how sure that is.

A place is rated for a paw by what it looks like, how well its views agree, how near it is to
the ground and to where such paws stand. Front and hind paw of a side are chosen together, and
a paw that one view sees in line with a surer one is doubted: there, the view may see the other.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pawnb.arrays import FloatArray, Points3D
from pawnb.core.paws.start_proposal.parameters import PAW_PROPOSAL
from pawnb.core.paws.start_proposal.places import CandidatePlaces, Stage
from pawnb.core.rig import Rig


@dataclass(frozen=True)
class Paw:
    """A point that is looked for.

    Parameters
    ----------
    point : str
        FR, HR, FL or HL.
    group : int
        Number of the group of views that track it.
    side : int
        1 on the animal's right, -1 on its left.
    is_front : bool
        Whether it is a front paw.
    """

    point: str
    group: int
    side: int
    is_front: bool


@dataclass(frozen=True)
class ViewGeometry:
    """Where views that track the same points see places.

    Parameters
    ----------
    rig : Rig
        The calibrated views.
    groups : sequence of sequence of str
        Names of the views of each group.
    paw_px : mapping of str to float
        Length of a paw in each view, px.
    """

    rig: Rig
    groups: Sequence[Sequence[str]]
    paw_px: Mapping[str, float]

    def apart(self, group: int, here: FloatArray, there: FloatArray) -> float:
        """Return how near two places come to each other in any view, in paw lengths.

        Parameters
        ----------
        group : int
            Number of the group of views.
        here, there : ndarray, shape (3,)
            Places in space.

        Returns
        -------
        float
            Paw lengths.
        """
        names = self.groups[group]
        uv = self.rig.subset(names).project(np.stack([here, there]))
        away = np.linalg.norm(uv[0] - uv[1], axis=-1)
        return float(min(d / self.paw_px[name] for d, name in zip(away, names, strict=True)))


def choose_places(
    parts: Sequence[CandidatePlaces], *, paws: Sequence[Paw], stage: Stage, geometry: ViewGeometry
) -> dict[Paw, tuple[Points3D, float]]:
    """Choose a place for each paw in one frame.

    Parameters
    ----------
    parts : sequence of CandidatePlaces
        What each group of views sees.
    paws : sequence of Paw
        The paws that are looked for.
    stage : Stage
        Where paws stand in the recording.
    geometry : ViewGeometry
        Where the groups see places.

    Returns
    -------
    dict
        For each paw that has a place, where it is and how sure that is (0 to 1).
    """
    chosen = {}
    for group, side in dict.fromkeys((paw.group, paw.side) for paw in paws):
        pair = {paw.is_front: paw for paw in paws if (paw.group, paw.side) == (group, side)}
        places = parts[group]
        scores = {is_front: _rate(places, stage, side, is_front) for is_front in pair}
        if len(pair) == 2:
            best, seen = _best_pair(places, scores, stage)
        else:
            seen = 1.0
            best = {k: int(score.argmax()) for k, score in scores.items() if len(score)}
        for is_front, k in best.items():
            chosen[pair[is_front]] = (places.xyz[k], seen * float(scores[is_front][k]))
    return _not_mistaken(_each_its_own(chosen, stage), geometry)


def _best_pair(
    places: CandidatePlaces, scores: Mapping[bool, np.ndarray], stage: Stage
) -> tuple[dict[bool, int], float]:
    """Return the best front and hind place of one side, and how clear of each other they are."""
    along = places.xyz @ stage.axes[0]
    apart = (along[:, None] - along[None]) / stage.span
    both = np.minimum(scores[True][:, None], scores[False][None])
    # paws that touch each other hide each other
    p = PAW_PROPOSAL
    far = 1.0 - np.exp(-0.5 * (apart / p.pair_clear) ** 2)
    clear = np.where(apart < p.pair_apart, 0.0, far)
    both = both * clear
    # of two equal pairs, the one whose better paw is better
    total = both + p.pair_better * (scores[True][:, None] + scores[False][None]) * (both > 0)
    if not total.size or total.max() <= 0:
        return {}, 0.0
    at = np.unravel_index(int(total.argmax()), total.shape)
    return {True: int(at[0]), False: int(at[1])}, float(clear[at])


def _not_mistaken(
    chosen: dict[Paw, tuple[np.ndarray, float]], geometry: ViewGeometry
) -> dict[Paw, tuple[np.ndarray, float]]:
    """Make paws less sure that a view may have mistaken for a surer paw in its line of sight."""
    kept = {}
    for paw, (xyz, score) in chosen.items():
        surer = [at for other, (at, sure) in chosen.items()
                 if other.point != paw.point and sure > score]  # fmt: skip
        apart = [geometry.apart(paw.group, xyz, at) for at in surer]
        nearest = min(apart, default=np.inf)
        kept[paw] = (xyz, score * float(1.0 - np.exp(-0.5 * (nearest / PAW_PROPOSAL.in_line) ** 2)))
    return kept


def _each_its_own(
    chosen: dict[Paw, tuple[np.ndarray, float]], stage: Stage
) -> dict[Paw, tuple[np.ndarray, float]]:
    """Leave out paws whose place is that of another paw that fits it better."""
    kept: dict[Paw, tuple[np.ndarray, float]] = {}
    for paw, (xyz, score) in sorted(chosen.items(), key=lambda item: -item[1][1]):
        others = [place for other, (place, _) in kept.items() if other.point != paw.point]
        least = PAW_PROPOSAL.same_place * stage.span
        if all(np.linalg.norm(xyz - place) >= least for place in others):
            kept[paw] = (xyz, score)
    return kept


def _rate(places: CandidatePlaces, stage: Stage, side: int, is_front: bool) -> FloatArray:
    """Return how well each place fits a paw, 0 to 1."""
    along, aside, height = (places.xyz @ stage.axes.T).T
    span, p = stage.span, PAW_PROPOSAL
    above = (height - stage.ground) / span
    fits = np.exp(-0.5 * (above / np.where(above > 0, p.above_sd, p.below_sd)) ** 2)
    off = (along - (stage.front if is_front else stage.hind)) / (p.along_sd * span)
    fits *= np.exp(-0.5 * off**2)
    outward = side * (aside - stage.middle) / span
    fits *= np.exp(-0.5 * ((outward - p.aside) / p.aside_sd) ** 2)
    views = np.where(
        np.isnan(places.residual),
        p.one_view,
        np.exp(-0.5 * (np.nan_to_num(places.residual) / p.paw_residual_sd) ** 2),
    )
    return fits * views * np.sqrt(np.clip(places.strength, 0.0, 1.0))
