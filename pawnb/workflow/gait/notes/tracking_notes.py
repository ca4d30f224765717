"""What a reader of a gait analysis must know of the tracking of its trials."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence

from pawnb.core.paws.offline.quality.assessment import Quality
from pawnb.core.paws.offline.self_training.doubted_clicks import (
    LOOK_AT_CLICKS,
    doubted_clicks_in_words,
    doubted_clicks_of,
)
from pawnb.core.video.doubts.cuts import cuts_in_words
from pawnb.gait.analysis.notes import Note, trial_of
from pawnb.schema import Tracks
from pawnb.workflow.gait.drawing.source_drawings import SourceTracks
from pawnb.workflow.provenance.results import provenance_steps

_STILL_COUNTS = "the trial counts like the others: review it, track it again, or leave it out"


def notes_on_tracking(seen: Sequence[SourceTracks]) -> list[Note]:
    """Say which trials have tracks that failed, or of films or clicks that do not go together.

    Parameters
    ----------
    seen : sequence of SourceTracks
        The tracks that were analysed.

    Returns
    -------
    list of Note
        The notes, each under its trial; nothing of tracks that another program made.
    """
    names = Counter(one.trial for one in seen)
    notes = []
    for one in seen:
        shared = names[one.trial] > 1 and one.animal is not None
        where = trial_of(str(one.animal), one.trial) if shared else one.trial
        said = [
            *_failed(one.quality),
            *_cuts(one.tracks),
            *_clicks(one.tracks),
            *_stopped(one.tracks),
        ]
        notes += [Note(sentence, where=where) for sentence in said]
    return notes


def _failed(quality: Quality | None) -> Iterator[str]:
    """Say that tracks failed, or which points of them."""
    if quality is None:
        return
    if quality.verdict == "failed":
        yield f"tracking {quality.line()}. No gait can be told from it, and {_STILL_COUNTS}."
        return
    failed = [point for point in quality.points if point.verdict == "failed"]
    if failed:
        told = ", ".join(f"{point.name} ({100 * point.expected_right:.0f} %)" for point in failed)
        yield (
            f"tracking of {told} failed: so much of its labels is expected to be right. Strides "
            "and phases with it count like the others: review it, track it again, or leave it out "
            "(--legs)."
        )


def _clicks(tracks: Tracks) -> Iterator[str]:
    """Say which clicks those of other frames contradict."""
    for words in doubted_clicks_in_words(doubted_clicks_of(tracks)):
        yield f"start clicks: {words}. Strides about them may be wrong: {LOOK_AT_CLICKS}."


def _cuts(tracks: Tracks) -> Iterator[str]:
    """Say where films leap."""
    for words in cuts_in_words(tracks):
        yield f"{words}. A stride across it is none: make a trial of each part, and track again."


def _stopped(tracks: Tracks) -> Iterator[str]:
    """Say that a run was stopped before its last frame, where its own notes do not."""
    made = [step for step in provenance_steps(tracks) if step["step"] == "track"]
    if not made or made[-1].get("complete", True) or not tracks.sizes["time"]:
        return
    step, frames = made[-1], tracks["frame"].to_numpy()
    if any(note.startswith("interrupted") for note in step.get("notes", ())):
        return
    yield (
        f"tracking was stopped: frames {frames[0]} to {frames[-1]} of {step['frames'][0]} to "
        f"{step['frames'][1] - 1} are tracked, and only these count; track again, which goes on."
    )
