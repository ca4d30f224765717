"""What the methods say of tracks: by what, at what frame rate, how good, how much by hand."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pawnb.core.edits.working_time import PAUSE_S
from pawnb.core.paws.offline.quality.assessment import Quality
from pawnb.schema import ORIGIN_CODE, Tracks
from pawnb.workflow.provenance.results import provenance_steps
from pawnb.workflow.reviewing.quality import verdict_on

_DEFAULT_METHOD = "pawnb"


def tracking_sentences(
    tracked: Sequence[Tracks], verdicts: Sequence[Quality | None] | None = None
) -> str:
    """Say in prose how the points of an analysis were tracked.

    Parameters
    ----------
    tracked : sequence of xarray.Dataset
        The tracks of all trials.
    verdicts : sequence of Quality or None, optional
        The verdict on each, where it is known already.

    Returns
    -------
    str
        Frames and frame rates, programs, labels by hand, what reviews have cost, reprojection
        residual and verdicts; empty without tracks.
    """
    if not tracked:
        return ""
    frames = sum(tracks.sizes["time"] for tracks in tracked)
    rates = sorted({float(tracks.attrs["fps"]) for tracks in tracked})
    rate = f"{rates[0]:g}" if len(rates) == 1 else f"{rates[0]:g} to {rates[-1]:g}"
    by = ", ".join(dict.fromkeys(_program(tracks) for tracks in tracked))
    said = [f"Points were tracked in {frames} frames at {rate} frames a second by {by}"]
    found = map(verdict_on, tracked) if verdicts is None else verdicts
    told = _verdicts([quality for quality in found if quality is not None])
    parts = (_by_hand(tracked), _reviewed(tracked), _residual(tracked), told)
    said += [words for words in parts if words]
    return ". ".join(said) + "."


def _program(tracks: Tracks) -> str:
    """Name what made tracks, and for ours the method and evidence."""
    program = str(tracks.attrs.get("source_software") or "a program that the file does not name")
    if program != _DEFAULT_METHOD:
        return program
    steps = [step for step in provenance_steps(tracks) if step["step"] == "track"]
    told = [f"method {step['method']}" for step in steps[-1:] if step.get("method")]
    if tracks.attrs.get("evidence"):
        told.append(f"evidence {tracks.attrs['evidence']}")
    return f"{_DEFAULT_METHOD} ({', '.join(told)})" if told else _DEFAULT_METHOD


def _by_hand(tracked: Sequence[Tracks]) -> str:
    """Say what share of labels a person placed; nothing of programs that do not record it."""
    codes = [
        t["origin"].to_numpy() for t in tracked if t.attrs.get("source_software") == _DEFAULT_METHOD
    ]
    if not codes:
        return ""
    there = sum(int((code != ORIGIN_CODE["missing"]).sum()) for code in codes)
    placed = sum(int((code == ORIGIN_CODE["edited"]).sum()) for code in codes)
    return f"{placed} of {there} labels were placed by hand" if there else ""


def _reviewed(tracked: Sequence[Tracks]) -> str:
    """Say how many trials a person has reviewed, with how many corrections, and in what time."""
    reviews = [
        [step for step in provenance_steps(tracks) if step["step"] == "review"][-1:]
        for tracks in tracked
    ]
    last = [step for steps in reviews for step in steps]
    if not last:
        return ""
    corrections = sum(int(step.get("corrections", 0)) for step in last)
    minutes = sum(float(step.get("minutes", 0)) for step in last)
    was = "was" if len(last) == 1 else "were"
    return (
        f"{len(last)} of {len(tracked)} recordings {was} reviewed in a widget: {corrections} "
        f"correction{'' if corrections == 1 else 's'} in {minutes:.1f} min of work "
        f"(gaps of over {PAUSE_S:g} s left out)"
    )


def _residual(tracked: Sequence[Tracks]) -> str:
    """Give the usual reprojection residual of tracks of several views."""
    values = [
        t["residual"].to_numpy().ravel()
        for t in tracked
        if "residual" in t and t.sizes.get("view", 1) > 1
    ]
    every = np.concatenate([np.empty(0), *values])
    every = every[np.isfinite(every)]
    return f"The median reprojection residual is {np.median(every):.2g} px" if len(every) else ""


def _verdicts(found: Sequence[Quality]) -> str:
    """Give the verdicts on tracks that pawnb made."""
    if not found:
        return ""
    right = [quality.expected_right for quality in found]
    counts = {name: sum(q.verdict == name for q in found) for name in ("good", "look", "failed")}
    told = ", ".join(f"{name} {n}" for name, n in counts.items() if n)
    least = f", {min(right):.0%} in the worst trial" if len(right) > 1 else ""
    return (
        f"By pawnb's own measures {np.mean(right):.0%} of labels are expected to be right{least} "
        f"(verdicts: {told})"
    )
