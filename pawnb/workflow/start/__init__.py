"""Starts without a click, and what looks wrong with a start.

``propose`` is the call; ``propose_pose`` serves jointed animals, ``sureness`` says in words how
sure a proposal is, ``start_doubts`` what looks wrong with a start frame.
"""

from pawnb import _lazy

__all__ = ["propose", "propose_pose", "start_doubts", "sureness"]

__getattr__, __dir__ = _lazy(__name__, __all__)
