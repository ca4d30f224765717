"""Questions about the most doubtful labels, answered by one key each: which paw is this."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from time import monotonic
from typing import Any

import numpy as np
import pandas as pd
import traitlets

from pawnb.core.edits.log import Accept, Swap
from pawnb.core.suspects.expected import Seen, expected_errors, seen_labels
from pawnb.errors import PawnbError
from pawnb.io.journal import Journal, LineFormat
from pawnb.widgets.page import as_text
from pawnb.widgets.question_sheet import MOST_CROPS, cut_out
from pawnb.widgets.retracking import Doubt, Retracking
from pawnb.workflow.reviewing.quality import clicks_of_tracks

RIGHT_ANSWER, NONE, SKIPPED = "right", "none", "skipped"
"""Answers that name no other point."""

_LONGEST_ANSWER_S = 60.0
"""Who takes longer over an answer is taken to have paused."""
_CUTOUT_PX, _CUTOUT_SHARE = 96.0, 0.14
"""Width of the part of a view that is shown: at least so many px, or this share of it."""
_MOST_KEYS = 9


@dataclass(frozen=True, kw_only=True)
class Answer:
    """What a person answered.

    Parameters
    ----------
    frame : int
        The frame.
    view, point : str
        The label that was asked about.
    answer : str
        ``right``, ``none``, ``skipped``, or the point that it is.
    seconds : float
        From question to answer; at most 60.
    """

    frame: int
    view: str
    point: str
    answer: str
    seconds: float


ANSWERS: LineFormat[Answer] = LineFormat({"answer": Answer})
"""The lines of ``answers.jsonl``."""


class Questions(Retracking):
    """The part of TrackReviewer that asks. Its ranking is that of the doubtful frames.

    Attributes
    ----------
    sheet : list of dict
        The labels that are asked about, the most doubtful first, each with a small picture;
        empty while nothing is asked.
    """

    sheet: traitlets.List = traitlets.List().tag(sync=True)

    session: Any  # ReviewSession; traitlets wants no stricter word here

    _answers: Journal[Answer] | None = None
    _answers_file: Path
    _question: tuple[int, str, str] | None = None  # frame, view and point
    _reason = ""
    _asked_at = 0.0
    _n_asked = 0
    _crops: dict[tuple[Any, ...], tuple[str, list[float]]] | None = None

    @property
    def answers(self) -> list[Answer]:
        """Every answer so far; they are in ``answers.jsonl`` beside the corrections."""
        if self._answers is None and self._answers_file.exists():
            self._open_answers()
        entries = [] if self._answers is None else self._answers.entries
        return [entry for entry in entries if isinstance(entry, Answer)]

    @property
    def expected_errors_left(self) -> float:
        """How many labels that nobody has looked at are expected to be wrong.

        Each counts with its chance of being wrong; those that a person has placed, accepted or
        answered for, and the same point in the same view up to three frames from there, count
        as right. How true that is: ``benchmarks/errors_left.py``.
        """
        tracks = self.session.present
        return expected_errors(tracks, clicks=clicks_of_tracks(tracks), seen=self._seen_right())

    def effort(self) -> dict[str, float]:
        """Return what the review has cost: minutes without pauses, corrections, and answers.

        Returns
        -------
        dict
            ``minutes``, over all sessions, and ``corrections`` in force; ``answers``, and
            ``answer_minutes``, the part of the minutes that they took.
        """
        minutes = sum(answer.seconds for answer in self.answers) / 60.0
        return super().effort() | {"answers": len(self.answers), "answer_minutes": minutes}

    def _seen_right(self) -> list[Seen]:
        """Return the labels of which a person has said, and not taken back, that they are right."""
        edits = self.session.corrections
        seen: list[Seen] = [(e.frame, e.view, e.point) for e in edits if isinstance(e, Accept)]
        swaps = [edit for edit in edits if isinstance(edit, Swap)]
        for said in self.answers:
            exchanged = any(
                {swap.first, swap.second} == {said.point, said.answer}
                and swap.frame <= said.frame
                and (swap.stop is None or said.frame < swap.stop)
                for swap in swaps
            )
            if exchanged:  # what is there now is what it was said to be
                seen.append((said.frame, said.view, said.answer))
        return seen

    def _leave_out_seen(self, doubtful: pd.DataFrame) -> pd.DataFrame:
        """Leave out of a list of doubtful labels those that a person has seen to be right."""
        tracks = self.session.present
        seen = seen_labels(tracks, self._seen_right())
        rows = np.searchsorted(tracks["frame"].to_numpy(), doubtful["frame"].to_numpy())
        at = [
            pd.Index(tracks[dim].to_numpy()).get_indexer(doubtful[column])
            for dim, column in (("view", "view"), ("keypoint", "point"))
        ]
        return doubtful[~seen[rows, at[0], at[1]]]

    def _question_actions(self) -> list[dict[str, Any]]:
        """Return the button that begins the questions, or the answers to the one that is asked."""
        if self._question is None:
            title = "Answer questions about the most doubtful labels, one key each (Q)"
            return [{"id": "ask", "text": "Questions", "keys": ["q"], "title": title,
                     "enabled": bool(self._suspects)}]  # fmt: skip
        asked = self._question[2]
        answers = [("Enter", f"Yes, {asked}", RIGHT_ANSWER)]
        # a point has the same key in every question
        for k, name in enumerate(self.session.points, 1):
            if name != asked:
                answers.append((str(k) if k <= _MOST_KEYS else "", f"{k}: {name}", f"is {name}"))
        answers += [("0", "0: none of them", NONE), ("s", "Skip", SKIPPED)]
        made = [
            {"id": f"answer {word}", "text": text, "keys": [key], "title": f"{text} ({key})"}
            for key, text, word in answers
        ]
        undo = {"id": "undo", "text": "Undo", "keys": ["Ctrl+z"], "title": "Take it back (Ctrl+Z)",
                "enabled": self.session.can_undo}  # fmt: skip
        end = {"id": "ask end", "text": "No more questions", "keys": ["q"], "title": "End (Q)"}
        return [*made, undo, end]

    def _act_on_question(self, action: str, value: Any = None) -> int | None:
        """Begin the questions, take an answer, or end them."""
        if action == "ask":
            if self._answers is None:
                self._open_answers()
            return self._ask()
        if action == "ask about":
            return self._ask_about(int(value))
        if action == "ask end":
            return self._end_questions("no more questions")
        return self._answer(action.removeprefix("answer "))

    def _open_answers(self) -> None:
        """Open the file of answers."""
        self._answers = Journal(self._answers_file, ANSWERS, made_in="review")

    def _ask(self) -> int | None:
        """Ask about the most doubtful label that was not asked about; returns its frame."""
        place = self._next_doubtful()
        if self._doubtful is None or place is None:
            return self._end_questions("no doubtful label is left to ask about")
        return self._put_question(self._doubt(place))

    def _put_question(self, doubt: Doubt) -> int:
        """Ask about a label; returns its frame."""
        frame, view, point, self._reason = doubt
        self._looked.add(doubt)
        self._place = 0  # the most doubtful first, also where the list was ranked anew
        self._question = (frame, view, point)
        self._n_asked += 1
        self._asked_at = monotonic()
        return self._show_question()

    def _ask_about(self, k: int) -> int | None:
        """Ask about another label of the sheet; that asked about before stays on the list."""
        if self._question is None or not 0 < k < len(self.sheet):
            return None
        chosen = self.sheet[k]
        self._looked.discard((*self._question, self._reason))
        return self._put_question(
            (chosen["frame"], chosen["view"], chosen["point"], chosen["reason"])
        )

    def _renew_sheet(self) -> None:
        """Put the labels on the sheet that are asked about now and next, in their order."""
        if self._question is None:
            self.sheet, self._crops = [], None
            return
        left = [d for k in range(len(self._suspects)) if (d := self._doubt(k)) not in self._looked]
        asked = [(*self._question, self._reason), *left[: MOST_CROPS - 1]]
        known, self._crops = self._crops or {}, {}
        sheet = []
        for frame, view, point, reason in asked:
            place = self.session.position(frame, view, point)
            key = (frame, view, place)
            cut = known.get(key) or self._cut(*key)
            if cut is not None:
                self._crops[key] = cut
                sheet.append({"frame": frame, "view": view, "point": point, "reason": reason,
                              "colour": self.session.colours[point], "url": cut[0], "at": cut[1],
                              "now": (frame, view, point) == self._question})  # fmt: skip
        self.sheet = sheet

    def _cut(
        self, frame: int, view: str, place: tuple[float, float] | None
    ) -> tuple[str, list[float]] | None:
        """Return the picture of a label, and where in it the label is; None where it has none."""
        if place is None:
            return None
        try:
            with self._video_lock:
                picture = self._views.frame(frame)[view]
        except PawnbError:  # said where the frame itself is shown
            return None
        width = next(stage["width"] for stage in self.stages if stage["name"] == view)
        data, at = cut_out(picture, place, max(_CUTOUT_PX, _CUTOUT_SHARE * width))
        return f"data:image/jpeg;base64,{as_text(data)}", at

    def _show_question(self) -> int:
        """Show the question that is asked; returns its frame."""
        assert self._question is not None  # noqa: S101
        self._pointed = frame, view, point = self._question
        left = sum(self._doubt(k) not in self._looked for k in range(len(self._suspects)))
        about = f"{self._reason}; frame {frame}, {left} more"
        self._renew_sheet()
        wrong = self.expected_errors_left
        self._show_state(
            f"is this {point} in {view}? ({about}). Expected errors left: {wrong:.0f} labels"
        )
        return frame

    def _ask_again(self, undone: Any) -> int | None:
        """After a correction was undone: what it was about may be asked again."""
        if undone is not None and self._question is not None:
            about = (getattr(undone, "frame", None), getattr(undone, "point", None))
            self._looked = {doubt for doubt in self._looked if (doubt[0], doubt[2]) != about}
        return self._show_question() if self._question is not None else None

    def _answer(self, word: str) -> int | None:
        """Take an answer, correct what it says, rank anew, and ask the next question."""
        if self._question is None:
            return None
        (frame, view, point), session = self._question, self.session
        assert self._answers is not None  # noqa: S101
        seconds = round(min(monotonic() - self._asked_at, _LONGEST_ANSWER_S), 2)
        said = word.removeprefix("is ")
        self._answers.append(
            Answer(frame=frame, view=view, point=point, answer=said, seconds=seconds)
        )
        if word == RIGHT_ANSWER:
            session.accept(frame, view, point)
        elif word == NONE or (word != SKIPPED and session.are_together(frame, point, said)):
            # where both are in one place, that of the other is right already: no exchange
            session.delete(frame, frame + 1, point, view=view)
        elif word != SKIPPED:
            begin, stop = session.stretch_between_crossings(frame, point, said)
            where = None if session.rig is not None else view
            session.swap(begin, point, said, stop=stop, view=where)
            self._tracked_again()
            for name in (point, said):
                self._doubt_no_more(begin, name, stop=stop)
            return self._ask()
        if word != SKIPPED:
            self._tracked_again()
            self._doubt_no_more(frame, point)
        return self._ask()

    def _end_questions(self, said: str) -> int | None:
        """Go on with the review, and say what the questions have cost."""
        self._question = None
        self._renew_sheet()
        spent = self.effort()
        cost = f"{spent['answers']} answers in {spent['answer_minutes']:.1f} min"
        cost += f". Expected errors left: {self.expected_errors_left:.0f} labels"
        self._show_state(f"{said}: {cost}" if self._answers is not None else said)
        return None

    def _look(self, frame: int) -> dict[str, Any]:
        """Return which part of each view the browser shows: that about the label asked for."""
        if self._question is None:
            return {"look": {"id": -self._n_asked, "views": {}}}
        at, _, point = self._question
        if at != frame:
            return {}
        parts = {}
        for stage in self.stages:
            place = self.session.position(frame, stage["name"], point)
            if place is not None:
                size = max(_CUTOUT_PX, _CUTOUT_SHARE * stage["width"])
                parts[stage["name"]] = [*place, min(size, stage["width"])]
        return {"look": {"id": self._n_asked, "views": parts}}
