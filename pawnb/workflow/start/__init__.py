"""Starts without a click, and what looks wrong with a start.

Comes in: a trial. Goes out: a start that a person confirms, and how sure it is. ``propose_start``
is the call; ``propose`` finds paws, ``propose_pose`` the pose of a jointed animal; ``proposed`` is
what both share, ``sureness`` says in words how sure a proposal is, ``start_doubts`` what looks
wrong with a start frame.
"""

from pawnb import _lazy

__all__ = ["propose", "propose_pose", "propose_start", "proposed", "start_doubts", "sureness"]

__getattr__, __dir__ = _lazy(__name__, __all__)
