"""From bare videos to a trial, and how far each trial of a folder is."""

from pawnb import _lazy

__all__ = ["animals", "new_trial", "page", "questions", "states"]

__getattr__, __dir__ = _lazy(__name__, __all__)
