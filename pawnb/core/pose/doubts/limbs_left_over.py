"""How much of what looks like limbs in a picture lies on no leg of the stick animal.

A leg that the stick animal lacks, legs that are too short, or another animal altogether: each leg
may then lie well on something dark, so that nothing in the fit of a frame speaks against it. What
is left over of the animal's outline does.
"""

from __future__ import annotations

import json

import numpy as np

from pawnb.arrays import BoolArray, FloatArray
from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.poses import Poses, joint_positions
from pawnb.core.pose.start_proposal.silhouette import Silhouette
from pawnb.schema import Tracks

LIMBS_LEFT_OVER = "limbs_left_over"
"""Attribute of tracks: JSON of some frames, each with what :func:`limbs_left_over` returns."""

_ON_LEG = 0.05
"""A limb's middle line is on a leg within this share of the leg span: so far apart are the tips of
a pose that counts as wrong (``benchmarks/pose_accuracy.py``)."""
_BODY_WIDER = 1.2
"""A body may be so many times as large as the species file has it. Set by hand."""


def limbs_left_over(outline: Silhouette, animal: StickAnimal, pose: Poses) -> float:
    """Return how long the limbs of an outline are that lie on no leg.

    Parameters
    ----------
    outline : Silhouette
        What differs from the empty scene in a frame.
    animal : StickAnimal
        The animal.
    pose : Poses
        Its pose in that frame.

    Returns
    -------
    float
        In lengths of a leg as it is seen, the middle one of all legs: 1 where one leg more is
        seen than the animal has.
    """
    places = joint_positions(animal, pose)[0]
    v, u = np.nonzero((outline.ridge == 0) & ~outline.core & outline.mask)
    points = outline.to_view(np.column_stack([u, v]))
    near = _away_from_legs(places, points) <= _ON_LEG * animal.span * float(pose.scale[0])
    near |= _on_body(animal, pose, points)
    reach = np.nanmax(np.hypot(*np.moveaxis(places - places[:, :1], -1, 0)), axis=1)
    return float((~near).sum()) * outline.shrink / max(float(np.median(reach)), 1.0)


def left_over_of(tracks: Tracks) -> float:
    """Return the median of what tracks carry of :func:`limbs_left_over`; 0 where they carry none.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks of a jointed animal.
    """
    of_frames = json.loads(str(tracks.attrs.get(LIMBS_LEFT_OVER, "{}")))
    return float(np.median(list(of_frames.values()))) if of_frames else 0.0


def _away_from_legs(places: FloatArray, points: FloatArray) -> FloatArray:
    """Return how far points (n, 2) are from the nearest segment of any leg, px."""
    near = np.full(len(points), np.inf)
    for leg in places:
        joints = leg[np.isfinite(leg).all(axis=1)]
        for begin, way in zip(joints[:-1], np.diff(joints, axis=0), strict=True):
            share = np.clip((points - begin) @ way / max(float(way @ way), 1e-9), 0.0, 1.0)
            off = points - begin - share[:, None] * way
            near = np.minimum(near, np.hypot(off[:, 0], off[:, 1]))
    return near


def _on_body(animal: StickAnimal, pose: Poses, points: FloatArray) -> BoolArray:
    """Return which points (n, 2) are on the body."""
    turn, on = np.radians(float(pose.heading_deg[0])), np.zeros(len(points), dtype=bool)
    away = (points - pose.xy[0]) / float(pose.scale[0])
    ahead = away @ [np.cos(turn), np.sin(turn)]
    right = away @ [-np.sin(turn), np.cos(turn)]
    for part in animal.body:
        along = (ahead - part.centre[0]) / (_BODY_WIDER * part.length / 2)
        across = (right - part.centre[1]) / (_BODY_WIDER * part.width / 2)
        on |= along**2 + across**2 < 1.0
    return on
