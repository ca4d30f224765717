"""Whether pictures are interlaced: each woven of two that were taken one after the other.

Cameras and programs that copy films often leave out the flag that says so.
"""

from __future__ import annotations

import numpy as np

from pawnb.core.pixels.grey import grey
from pawnb.core.video.views import ViewReader

HOW_TO_MEND = (
    "what moves is seen twice, in every other row. Make each a picture of its own, which doubles "
    "fps, with: ffmpeg -i IN -vf bwdif=mode=send_field -crf 12 OUT.mp4"
)

_COMPARED_AT = (0.2, 0.4, 0.6, 0.8)
"""Of the frames, where two that follow each other are compared."""
_MOVED_GREY = 12.0
"""Change of grey from frame to frame that is no noise."""
_FEWEST_PIXELS = 300
"""Pixels that move, of which fewer tell nothing."""
_STANDS_OUT = 10.0
"""A pixel is combed where it differs by so much, in grey, from those above and below (the root of
the product), in one direction."""
_COMBED, _TIMES_SIDEWAYS, _ABOVE = 0.12, 1.25, 0.02
"""Share of moving pixels that are combed, and how it compares with that across columns. Measured:
six real clips have 0 to 25 % in rows and as many or more in columns; woven of two pictures each 15
to 53 % and 0 to 28 %."""


def looks_interlaced(reader: ViewReader, *, start: int, stop: int) -> bool:
    """Tell whether what moves in a film is seen twice, in every other row.

    Parameters
    ----------
    reader : ViewReader
        The view.
    start, stop : int
        Frames of its file that are used, half open.

    Returns
    -------
    bool
        False also where too little moves to tell.
    """
    frames = sorted({start + int(place * (stop - start - 1)) for place in _COMPARED_AT})
    found = [_share_combed(reader, k) for k in frames if k + 1 < stop]
    shares = [share for share in found if share is not None]
    if not shares:
        return False
    rows, columns = np.median(shares, axis=0)
    return bool(rows > max(_COMBED, _TIMES_SIDEWAYS * columns + _ABOVE))


def _share_combed(reader: ViewReader, frame: int) -> tuple[float, float] | None:
    """Return which share of moving pixels stand out of both neighbours: by row, and by column."""
    before, now = (grey(reader.read(k)) for k in (frame, frame + 1))
    moved = np.abs(now - before) > _MOVED_GREY
    if moved.sum() < _FEWEST_PIXELS or min(now.shape) < 3:
        return None
    up, down = now[:-2] - now[1:-1], now[2:] - now[1:-1]
    left, right = now[:, :-2] - now[:, 1:-1], now[:, 2:] - now[:, 1:-1]
    rows = (up * down > _STANDS_OUT**2)[moved[1:-1]]
    columns = (left * right > _STANDS_OUT**2)[moved[:, 1:-1]]
    return float(rows.mean()), float(columns.mean())
