"""Videos, exactly: the frame you ask for is the frame you get.

Comes in: a file. Goes out: its frames by number, whole or in part, and what is damaged in it. All
packets are listed first (``listing``); a frame is decoded from the nearest one before it that needs
no other (``units`` of H.264), and ``parts`` decodes a part of a picture alone.
"""

from pawnb.core.video.file import VideoFile
from pawnb.core.video.opening import open_view, open_views
from pawnb.core.video.views import Frame, ViewReader
from pawnb.core.video.viewset import ViewSet

__all__ = ["Frame", "VideoFile", "ViewReader", "ViewSet", "open_view", "open_views"]


def __dir__() -> list[str]:
    """List the public names."""
    return sorted(__all__)
