"""From bare videos to a trial, and how far each trial of a folder is.

Comes in: a folder. Goes out: its trials with what is done, what is next and what is wrong
(``states``), or a ``trial.toml`` that is written from videos and answers.
"""

from pawnb import _lazy

__all__ = ["animals", "new_trial", "page", "questions", "states"]

__getattr__, __dir__ = _lazy(__name__, __all__)
