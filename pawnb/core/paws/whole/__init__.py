"""The paw tracker that decides over the whole recording."""

from pawnb.core.paws.whole.settings import WholeSettings
from pawnb.core.paws.whole.tracker import doubt_clicks, track_whole

__all__ = ["WholeSettings", "doubt_clicks", "track_whole"]
