"""What looks wrong in the pictures of films, though their files do not say it.

Comes in: open views. Goes out: whether each picture is woven of two (``interlaced``), which views
are given one film (``one_film``), and where pictures are shown again (``repeated``).
"""

from pawnb import _lazy

__all__ = ["interlaced", "one_film", "repeated"]

__getattr__, __dir__ = _lazy(__name__, __all__)
