"""How good tracks are, and where to look or click next.

``quality`` gives the verdict, ``suggest`` the frames in which a click helps most, ``reproject``
shows tracks in every view.
"""

from pawnb import _lazy

__all__ = ["quality", "reproject", "suggest"]

__getattr__, __dir__ = _lazy(__name__, __all__)
