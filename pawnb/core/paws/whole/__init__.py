"""The paw tracker that decides over the whole recording."""

from pawnb.core.paws.whole.settings import WholeSettings
from pawnb.core.paws.whole.tracker import track_whole

__all__ = ["WholeSettings", "track_whole"]
