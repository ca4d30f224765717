"""What looks wrong in the pictures of films, though their files do not say it.

``interlaced``: each woven of two; ``one_film``: one film given for two views.
"""

from pawnb import _lazy

__all__ = ["interlaced", "one_film"]

__getattr__, __dir__ = _lazy(__name__, __all__)
