"""What a tracked stick animal leaves over of the animal in its film, for the verdict."""

from __future__ import annotations

import json

import numpy as np

from pawnb.core.pose.as_tracks import animal_of, poses_of
from pawnb.core.pose.background import Background
from pawnb.core.pose.doubts.limbs_left_over import LIMBS_LEFT_OVER, limbs_left_over
from pawnb.core.pose.start_proposal.silhouette import find_silhouette
from pawnb.core.video import ViewReader
from pawnb.schema import Tracks

_OUTLINED_FRAMES = 25
"""So many frames, spread over the recording, are looked at: about 30 ms each of 640 x 512 px, and
0.2 s of 1920 x 1080 px."""


def with_left_over(
    tracks: Tracks, *, reader: ViewReader, background: Background, again: range | None = None
) -> Tracks:
    """Return tracks that carry how much of what looks like limbs lies on no leg.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks of a jointed animal.
    reader : ViewReader
        The view that poses are in.
    background : Background
        Its empty scene.
    again : range, optional
        The frames that were tracked again: of others what the tracks carry is kept. Default all.

    Returns
    -------
    xarray.Dataset
        The same with attribute ``limbs_left_over``: frames in which anything differs from the
        empty scene, each with its lengths of a leg.
    """
    animal, poses = animal_of(tracks), poses_of(tracks).poses
    rows = np.flatnonzero(np.isfinite(poses.xy).all(axis=1))
    n = min(_OUTLINED_FRAMES, len(rows))
    before = {} if again is None else json.loads(str(tracks.attrs.get(LIMBS_LEFT_OVER, "{}")))
    found = {}
    for row in rows[np.linspace(0, len(rows) - 1, n).astype(int)].tolist():
        frame = int(poses.frames[row])
        if again is not None and frame not in again and str(frame) in before:
            found[str(frame)] = before[str(frame)]
            continue
        outline = find_silhouette(reader.frame(frame).image(), background)
        if outline is not None:
            left_over = limbs_left_over(outline, animal, poses.take([row]))
            found[str(frame)] = round(left_over, 3)
    return tracks.assign_attrs({LIMBS_LEFT_OVER: json.dumps(found)})
