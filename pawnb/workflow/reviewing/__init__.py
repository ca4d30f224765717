"""How good tracks are, and where to look or click next.

Comes in: tracks and their trial. Goes out: a verdict, and frames to look at. ``quality`` gives the
verdict, ``suggest`` the frames in which a click helps most, ``foreign`` opens other programs'
tracks for a review and writes them back, ``reproject`` shows tracks in every view.
"""

from pawnb import _lazy

__all__ = ["foreign", "quality", "reproject", "suggest"]

__getattr__, __dir__ = _lazy(__name__, __all__)
