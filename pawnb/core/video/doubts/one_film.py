"""Whether one film is given for two views."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.core.pixels.grey import grey
from pawnb.core.video.views import Source
from pawnb.core.video.viewset import ViewSet

_LEAST_APART, _FLAT_GREY = 0.5, 5.0
"""Pictures that differ by less, RMS as a share of their standard deviation, are of one camera; one
that is flatter, in grey values, tells nothing. Measured: thirteen real films that were compressed
again (H.264, crf 18 to 35) differ by 0.02 to 0.38, cameras side by side (a fly, mice in a cage,
rendered mice: 21 pairs) by 0.76 to 1.5. Small animals before a plain ground differ by 1.4."""


def tell_same_films(views: ViewSet) -> list[str]:
    """Say which files begin with the same picture, as those of two cameras never do.

    Parameters
    ----------
    views : ViewSet
        The open views.

    Returns
    -------
    list of str
        A sentence for each two files.
    """
    files = {id(reader.source): name for name, reader in reversed(views.readers.items())}
    names = [name for name in views.names if name in files.values()]
    if len(names) < 2:
        return []
    first = {name: _first(views.readers[name].source) for name in names}
    return [
        f"the films of views {a} and {b} begin with the same picture: one film seems to be given "
        "for both, or two films of one camera; name the film of each"
        for a, b in combinations(names, 2)
        if first[a].shape == first[b].shape
        and first[a].std() > _FLAT_GREY
        and np.sqrt(np.mean((first[a] - first[b]) ** 2)) < _LEAST_APART * first[a].std()
    ]


def _first(source: Source) -> FloatArray:
    """Return the grey values of a file's first picture."""
    return np.asarray(grey(source.grab(0).region(0, 0, source.width, source.height)))
