"""The verdict on tracks, good, look or failed: told after tracking, and beside its results."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pandas as pd

from pawnb.core.paws.offline.quality.assessment import Quality, assess
from pawnb.core.paws.offline.quality.measures import CALIBRATED
from pawnb.core.paws.offline.self_training.doubted_clicks import (
    doubted_clicks_in_words,
    doubted_clicks_of,
)
from pawnb.core.pose.as_tracks import BODY_POINT, animal_of, is_pose, poses_of
from pawnb.core.pose.doubts.limbs_left_over import left_over_of
from pawnb.core.pose.doubts.on_another_leg import legs_on_another
from pawnb.core.pose.doubts.travel import goes_backwards
from pawnb.core.pose.pose_suspects import chances_of_crossing, chances_of_tips
from pawnb.core.suspects.moved_views import MOVED_VIEWS
from pawnb.core.video.doubts.cuts import cuts_in_words
from pawnb.core.video.doubts.frozen_labels import freezes_in_words, freezes_of_tracks
from pawnb.errors import InputError, QualityWarning
from pawnb.files import as_word, read_text
from pawnb.input_warnings import warn_of_input
from pawnb.schema import START_COLUMNS, Tracks
from pawnb.schema.arguments import checked_arguments

QUALITY_FILE = "quality.json"

_LEFT_OVER_SAID = 0.3
"""Limbs that lie on no leg are spoken of from so many legs' lengths on. By hand: 0.00 to 0.08 in
fifteen rendered spiders (0.17 in H.264 of crf 40), 0.10 for a real orb weaver (spider-nephila), of
which the legs are right; 0.54 and 0.73 where the stick animal lacks a leg, 0.9 where it has half
the size, 0.4 and 0.5 where legs are blurred and 64 % of tips are right (pawnb demo spider, seed 0),
2.4 of the orb weaver the wrong way round. A walking fly, 85 % right, has 0.2 to 0.4."""

EXIT_FAILED = 3
"""Exit status of a command that wrote its results, and whose verdict on them is *failed*."""


@checked_arguments
def assess_quality(tracks: Tracks) -> Quality:
    """Say how good the tracks of a recording are, as they stand now.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks with image positions. Of a jointed animal the body and the tips count.

    Returns
    -------
    Quality
        ``verdict`` is ``"failed"`` where fewer than half of the labels are expected to be right,
        ``"look"`` below 90 %, or where clicks contradict each other or a film is cut, else
        ``"good"``; so has each of its ``points``, with reasons.
        ``line()`` says it in one line.

    Raises
    ------
    InputError
        If the tracks have no image positions.

    Examples
    --------
    >>> pawnb.assess_quality(tracks).verdict in ("good", "look", "failed")
    True
    """
    if is_pose(tracks):
        quality = assess(_with_chances(tracks))
    else:
        quality = assess(tracks, clicks=clicks_of_tracks(tracks))
    still = tuple(
        f"the film of view {view} stands still in {freezes_in_words(own)}"
        for view, own in freezes_of_tracks(tracks).items()
    )
    moved = json.loads(tracks.attrs.get(MOVED_VIEWS, "[]"))
    clicked = doubted_clicks_in_words(doubted_clicks_of(tracks))
    cuts = cuts_in_words(tracks)
    doubts = _doubts_about_animal(tracks) if is_pose(tracks) else []
    if is_pose(tracks):
        quality, doubled = _doubled_legs(quality, tracks)
        doubts += doubled
    # labels go through every click, and across a cut
    if (clicked or cuts or doubts) and quality.verdict == "good":
        quality = replace(quality, verdict="look")
    return replace(quality, reasons=(*still, *cuts, *moved, *clicked, *doubts, *quality.reasons))


def _doubts_about_animal(tracks: Tracks) -> list[str]:
    """Say what speaks against all legs at once, however well each lies on something dark."""
    doubts = []
    left_over = left_over_of(tracks)
    if left_over >= _LEFT_OVER_SAID:
        doubts.append(
            f"limbs that together are {left_over:.1f} times as long as a leg lie on no leg of the "
            "stick animal (the median of some frames): it may lack a leg, have short ones or face "
            "the other way, or legs lie on others' places (long antennae and palps count as limbs)"
        )
    if goes_backwards(animal_of(tracks), poses_of(tracks).poses):
        doubts.append(
            "the animal goes backwards by its heading; if it does not, every leg is taken for "
            "another: turn the stick animal about in the start pose, and track again"
        )
    return doubts


def _doubled_legs(quality: Quality, tracks: Tracks) -> tuple[Quality, list[str]]:
    """Return the verdict with the legs that lie along another one doubted, and what is said."""
    said = {
        leg: f"{leg} lies along {other} in {100 * share:.0f} % of frames: if the animal lacks it, "
        f"say so (M in StickPoser, or 0 under {leg}_scale in start_pose.csv), and track again"
        for leg, (other, share) in legs_on_another(
            animal_of(tracks), poses_of(tracks).poses
        ).items()
    }
    points = tuple(
        replace(p, verdict="look" if p.verdict == "good" else p.verdict,
                reasons=(said[p.name], *p.reasons)) if p.name in said else p
        for p in quality.points
    )  # fmt: skip
    return replace(quality, points=points), list(said.values())


def verdict_on(tracks: Tracks) -> Quality | None:
    """Return how good tracks are that pawnb made; None of others, and of places in space alone.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks of any program.
    """
    if tracks.attrs.get("source_software") != "pawnb" or "image_position" not in tracks:
        return None
    try:
        return assess_quality(tracks)
    except InputError:
        return None


def _with_chances(tracks: Tracks) -> Tracks:
    """Return body and tips; of one view their labels have the probability of being right."""
    poses = tracks.sel(keypoint=[BODY_POINT, *animal_of(tracks).leg_names])
    if poses.sizes["view"] > 1:
        return poses  # in space all views decide
    sure = poses["image_confidence"]
    if "sd" not in poses:  # those of method "paper"
        dims = ("time", "view", "keypoint", "individual")
        chances = sure.transpose(*dims).copy(data=chances_of_crossing(tracks)[:, None, :, None])
        confidence = chances.where(sure > 0.0, 0.0).transpose(*sure.dims)
    else:
        # where no leg is seen, as where a film stands still, there is no body that legs follow
        is_seen = sure.sel(keypoint=BODY_POINT, drop=True) > 0.0
        chances = sure.copy(data=chances_of_tips(sure.to_numpy()))
        confidence = chances.where(is_seen, 0.0).transpose(*sure.dims)
    confidence.attrs[CALIBRATED] = 1
    return poses.assign(image_confidence=confidence)


def clicks_of_tracks(tracks: Tracks) -> pd.DataFrame | None:
    """Return every click that tracks were made from; None where they do not say.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks.

    Returns
    -------
    DataFrame or None
        frame, view, point, u, v (px).
    """
    steps = json.loads(tracks.attrs.get("provenance", "{}")).get("steps", [])
    rows = [
        row for step in steps for row in step.get("start", ()) if set(START_COLUMNS) <= set(row)
    ]
    return pd.DataFrame(rows, columns=list(START_COLUMNS)) if rows else None


def quality_text(quality: Quality) -> str:
    """Return the text of ``quality.json``; the same tracks give the same bytes.

    Parameters
    ----------
    quality : Quality
        The verdict.
    """
    return json.dumps(quality.document(), indent=1, ensure_ascii=False) + "\n"


def read_verdict(folder: str | Path) -> str:
    """Return the verdict that a folder of results holds, or an empty text.

    Parameters
    ----------
    folder : str or Path
        The folder.
    """
    try:
        document = json.loads(read_text(Path(folder) / QUALITY_FILE, expected="a verdict"))
        return str(document["verdict"])
    except (OSError, InputError, ValueError, KeyError, TypeError):
        return ""


def next_step(quality: Quality, out: str | Path, *, of_poses: bool = False) -> str:
    """Say what to do with tracks of a verdict.

    Parameters
    ----------
    quality : Quality
        The verdict.
    out : str or Path
        Folder of the results.
    of_poses : bool
        Whether they are of a jointed animal.

    Returns
    -------
    str
        A command, or words.
    """
    reviewer = "PoseReviewer" if of_poses else "TrackReviewer"
    if quality.verdict == "good" and not quality.poor_points:
        return f"pawnb gait {as_word(out)}"
    if quality.verdict in ("good", "look"):
        return f"review (pawnb.widgets.{reviewer}), then pawnb gait {as_word(out)}"
    if of_poses:
        return "pose the animal anew (pawnb.widgets.StickPoser), and track again"
    return "click the points in more frames (pawnb suggest names some), and track again"


def tell_failed(tracks: Tracks, *, complete: bool) -> None:
    """Warn of tracks that failed.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks as they were made.
    complete : bool
        Whether the run was; nothing is said of one that a person stopped.

    Warns
    -----
    QualityWarning
        If the verdict is *failed*.
    """
    if complete and (quality := assess_quality(tracks)).verdict == "failed":
        warn_of_input(f"tracking {quality.line()}", QualityWarning, stacklevel=3)
