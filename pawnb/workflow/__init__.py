"""Trial to tracks to gait, each step one call."""

from pawnb import _submodules

__getattr__ = _submodules(__name__)
