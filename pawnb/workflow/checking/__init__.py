"""What a trial has, what is missing, and what looks wrong.

``check`` is the call; ``check_pose`` adds what a jointed animal needs, ``check_report`` puts into
words what was found.
"""

from pawnb import _lazy

__all__ = ["check", "check_pose", "check_report"]

__getattr__, __dir__ = _lazy(__name__, __all__)
