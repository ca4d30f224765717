"""What a trial has, what is missing, and what looks wrong.

Comes in: a trial. Goes out: findings in words. ``check`` is the call; ``check_points`` adds what
points need, ``check_pose`` what a jointed animal does, ``check_report`` puts into words what was
found. ``selfcheck`` checks the installation itself, by ``reference_values`` and rendered trials.
"""

from pawnb import _lazy

__all__ = ["check", "check_points", "check_pose", "check_report", "reference_values", "selfcheck"]

__getattr__, __dir__ = _lazy(__name__, __all__)
