"""Videos, exactly: the frame you ask for is the frame you get."""

from pawnb.core.video.file import VideoFile
from pawnb.core.video.opening import open_view, open_views
from pawnb.core.video.views import Frame, ViewReader
from pawnb.core.video.viewset import ViewSet

__all__ = ["Frame", "VideoFile", "ViewReader", "ViewSet", "open_view", "open_views"]


def __dir__() -> list[str]:
    """List the public names."""
    return sorted(__all__)
