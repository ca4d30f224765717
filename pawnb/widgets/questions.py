"""Questions about the most doubtful labels, answered by one key each: which paw is this."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from time import monotonic
from typing import Any

from pawnb.io.journal import Journal, LineFormat
from pawnb.widgets.retracking import Retracking

RIGHT, NONE, SKIPPED = "right", "none", "skipped"
"""Answers that name no other point."""

_LONGEST_S = 60.0
"""Who takes longer over an answer is taken to have paused."""
_LEAST_PX, _SHARE = 96.0, 0.14
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
    """The part of TrackReviewer that asks. Its ranking is that of the doubtful frames."""

    session: Any  # ReviewSession; traitlets wants no stricter word here

    _answers: Journal[Answer] | None = None
    _answers_file: Path
    _question: tuple[int, str, str] | None = None  # frame, view and point
    _reason = ""
    _asked_at = 0.0
    _n_asked = 0

    @property
    def answers(self) -> list[Answer]:
        """Every answer so far; they are in ``answers.jsonl`` beside the corrections."""
        entries = [] if self._answers is None else self._answers.entries
        return [entry for entry in entries if isinstance(entry, Answer)]

    def effort(self) -> dict[str, float]:
        """Return what the review has cost: answers, minutes over them, and corrections.

        Returns
        -------
        dict
            ``answers``, ``minutes`` and ``corrections``.
        """
        minutes = sum(answer.seconds for answer in self.answers) / 60.0
        n = len(self.corrected.corrections)
        return {"answers": len(self.answers), "minutes": minutes, "corrections": n}

    def _question_actions(self) -> list[dict[str, Any]]:
        """Return the button that begins the questions, or the answers to the one that is asked."""
        if self._question is None:
            title = "Answer questions about the most doubtful labels, one key each (Q)"
            return [{"id": "ask", "text": "Questions", "keys": ["q"], "title": title,
                     "enabled": bool(self._suspects)}]  # fmt: skip
        asked = self._question[2]
        answers = [("Enter", f"Yes, {asked}", RIGHT)]
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

    def _act_on_question(self, action: str) -> int | None:
        """Begin the questions, take an answer, or end them."""
        if action == "ask":
            if self._answers is None:
                self._answers = Journal(self._answers_file, ANSWERS, made_in="review")
            return self._ask()
        if action == "ask end":
            return self._end_questions("no more questions")
        return self._answer(action.removeprefix("answer "))

    def _ask(self) -> int | None:
        """Ask about the most doubtful label that was not asked about; returns its frame."""
        place = self._next_doubtful()
        if self._doubtful is None or place is None:
            return self._end_questions("no doubtful label is left to ask about")
        frame, view, point, self._reason = self._doubt(place)
        self._looked.add((frame, view, point, self._reason))
        self._place = 0  # the most doubtful first, also where the list was ranked anew
        self._question = (frame, view, point)
        self._n_asked += 1
        self._asked_at = monotonic()
        return self._show_question()

    def _show_question(self) -> int:
        """Show the question that is asked; returns its frame."""
        assert self._question is not None  # noqa: S101
        self._pointed = frame, view, point = self._question
        left = sum(self._doubt(k) not in self._looked for k in range(len(self._suspects)))
        about = f"{self._reason}; frame {frame}, {left} more"
        self._show_state(f"is this {point} in {view}? ({about})")
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
        seconds = round(min(monotonic() - self._asked_at, _LONGEST_S), 2)
        said = word.removeprefix("is ")
        self._answers.append(
            Answer(frame=frame, view=view, point=point, answer=said, seconds=seconds)
        )
        if word == RIGHT:
            session.accept(frame, view, point)
        elif word == NONE:
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
        spent = self.effort()
        cost = f"{spent['answers']} answers in {spent['minutes']:.1f} min"
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
                size = max(_LEAST_PX, _SHARE * stage["width"])
                parts[stage["name"]] = [*place, min(size, stage["width"])]
        return {"look": {"id": self._n_asked, "views": parts}}
