"""What a run has learnt of a view beside its clicks, and how it is kept with the tracks.

With it a further click, or a correction, is learnt in one round: what the first round is for,
frames in which appearance and the whole model agree and how far correlation is trusted, is known.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from pawnb.arrays import AnyArray, Float32Array
from pawnb.core.paws.offline.detection.appearance import TrainingFrame
from pawnb.core.paws.offline.scene.stack import BodyStack
from pawnb.schema import Tracks

LEARNT_IN = "learnt_in"
"""Attribute of tracks: for each view the frames that were learnt from, and how far correlation was
trusted, as JSON."""
_DIGITS = 3
"""Layout: digits of what is written of the run."""


@dataclass(frozen=True)
class Learnt:
    """What was learnt of one view.

    Parameters
    ----------
    training_frames : mapping
        Row to what was agreed on there; positions are px of the view.
    agreement : mapping
        Point to the share of rows in which correlation agreed (:func:`.agreeing_share`).
    """

    training_frames: Mapping[int, TrainingFrame] = field(default_factory=dict)
    agreement: Mapping[int, float] = field(default_factory=dict)

    def part(self, begin: int, end: int) -> Learnt:
        """Return that of the rows from ``begin`` up to ``end``, counted from ``begin``."""
        inside = {
            row - begin: own for row, own in self.training_frames.items() if begin <= row < end
        }
        return Learnt(inside, self.agreement)

    def working(self, stack: BodyStack) -> dict[int, TrainingFrame]:
        """Return the examples with positions in working px of a stack of the same rows."""
        return {
            row: _moved(own, stack.to_body[row, :, :2], stack.to_body[row, :, 2])
            for row, own in self.training_frames.items()
        }

    @classmethod
    def of_working(
        cls,
        training_frames: Mapping[int, TrainingFrame],
        agreement: Mapping[int, float],
        stack: BodyStack,
    ) -> Learnt:
        """Return what was learnt in working px of a stack.

        Parameters
        ----------
        training_frames : mapping
            Row to what was learnt there, in working px.
        agreement : mapping
            Point to how far its kinds of evidence agree.
        stack : BodyStack
            The stack.

        Returns
        -------
        Learnt
            The same in px of the view.
        """
        in_view = {}
        for row, own in training_frames.items():
            back = np.linalg.inv(stack.to_body[row, :, :2])
            in_view[row] = _moved(own, back, -back @ stack.to_body[row, :, 2])
        return cls(in_view, agreement)


@dataclass(frozen=True)
class Earlier:
    """An earlier run on one view; n rows, P points.

    Parameters
    ----------
    learnt : Learnt
        What it has learnt.
    uv : ndarray, shape (n, P, 2)
        Where it has put the points, px of the view; NaN where nowhere.
    chance : ndarray, shape (n, P)
        How likely that is right.
    """

    learnt: Learnt
    uv: np.ndarray
    chance: np.ndarray

    def mean_mass(self, stack: BodyStack, point: int, prior: AnyArray) -> Float32Array:
        """Return the mean probability of every place (h, w) over the rows.

        Parameters
        ----------
        stack : BodyStack
            The view, of the same rows.
        point : int
            The point.
        prior : ndarray, shape (h, w)
            Where it is in rows in which it was not found.

        Returns
        -------
        ndarray of float32, shape (h, w)
            It sums to 1.
        """
        _, h, w = stack.shape
        found = np.isfinite(self.uv[:, point]).all(axis=-1)
        chance = np.where(found, self.chance[:, point], 0.0)
        mass = (1 - chance).sum() * np.asarray(prior, float)
        A = stack.to_body[found]
        xy = np.einsum("nij,nj->ni", A[..., :2], self.uv[found, point]) + A[..., 2]
        x, y = np.rint(stack.to_grid(xy)).astype(int).T
        np.add.at(mass, (np.clip(y, 0, h - 1), np.clip(x, 0, w - 1)), chance[found])
        return np.asarray(mass / len(found), np.float32)


def learnt_as_text(learnt: Mapping[str, Learnt], points: Sequence[str], first: int) -> str:
    """Return what was learnt of some views as the value of an attribute of tracks.

    Parameters
    ----------
    learnt : mapping
        View to what was learnt of it.
    points : sequence of str
        Names of the points, in the order of their numbers.
    first : int
        Frame of row 0.

    Returns
    -------
    str
        JSON, to be read by :func:`learnt_of`.
    """

    def text_of(own: TrainingFrame) -> dict[str, object]:
        places = {points[p]: np.round(uv, _DIGITS).tolist() for p, uv in own.points.items()}
        return {"points": places, "doubtful": [np.round(d, _DIGITS).tolist() for d in own.doubtful]}

    views = {
        view: {
            "frames": {str(first + row): text_of(one) for row, one in own.training_frames.items()},
            "agreement": {points[p]: round(share, 4) for p, share in own.agreement.items()},
        }
        for view, own in learnt.items()
    }
    return json.dumps(views, sort_keys=True)


def learnt_of(tracks: Tracks, points: Sequence[str], first: int) -> dict[str, Learnt]:
    """Return what the run that made these tracks has learnt, view by view.

    Parameters
    ----------
    tracks : Tracks
        The tracks; those that say nothing give nothing.
    points : sequence of str
        Names of the points, in the order of their numbers.
    first : int
        Frame of row 0.

    Returns
    -------
    dict
        View to what was learnt of it.
    """
    number = {name: p for p, name in enumerate(points)}

    def training_frame(said: dict[str, dict[str, list[float]]]) -> TrainingFrame:
        places = {number[p]: np.array(uv) for p, uv in said["points"].items() if p in number}
        return TrainingFrame(places, [np.array(uv) for uv in said["doubtful"]], clicked=False)

    return {
        view: Learnt(
            {int(frame) - first: training_frame(own) for frame, own in said["frames"].items()},
            {number[p]: float(s) for p, s in said["agreement"].items() if p in number},
        )
        for view, said in json.loads(tracks.attrs.get(LEARNT_IN, "{}")).items()
    }


def _moved(training_frame: TrainingFrame, turned: np.ndarray, shifted: np.ndarray) -> TrainingFrame:
    """Return an example whose positions have gone through an affine map."""
    return TrainingFrame(
        {p: turned @ xy + shifted for p, xy in training_frame.points.items()},
        [turned @ xy + shifted for xy in training_frame.doubtful],
        clicked=training_frame.clicked,
    )
