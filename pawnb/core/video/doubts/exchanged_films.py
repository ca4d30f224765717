"""Whether a film is that in which a start was made, or was exchanged or replaced since."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from contextlib import suppress
from typing import Any

import cv2
import numpy as np

from pawnb.core.pixels.grey import grey
from pawnb.core.video.views import Source
from pawnb.errors import PawnbError

_PARTS_ACROSS = 8
_FLATTEST_GREY = 5.0
"""A first picture that is flatter, in grey values, tells nothing."""
_ALIKE_BITS, _UNLIKE_BITS = 6, 12
"""Of 64 bits, pictures of one camera differ by at most so many and of two by at least so many.
Measured: first pictures of eleven cameras (mouse-4cam-cage, fly_ball_left, a rendered mouse)
differ by 0 to 10 once compressed hard (H.264, crf 38), also at half the size, from those of the
other cameras by 13 to 42."""
_CODE = re.compile(rf"p[0-9a-f]{{{_PARTS_ACROSS * _PARTS_ACROSS // 4}}}")


def film_code(source: Source) -> str:
    """Return a code of a film's first picture, which stays alike where it is compressed again.

    It says of each of 8 x 8 parts whether it is lighter than the part to its left, so neither
    names of files nor codecs, sizes of pictures and brightness matter.

    Parameters
    ----------
    source : Source
        The film.

    Returns
    -------
    str
        ``p`` and 16 hexadecimal digits; empty where the picture is flat or cannot be read.
    """
    picture = None
    with suppress(PawnbError):  # of damaged films it is said elsewhere
        picture = grey(source.grab(0).region(0, 0, source.width, source.height))
    if picture is None or picture.std() < _FLATTEST_GREY:
        return ""
    whole = np.asarray(picture, np.float32)
    parts = cv2.resize(whole, (_PARTS_ACROSS + 1, _PARTS_ACROSS), interpolation=cv2.INTER_AREA)
    return "p" + np.packbits(parts[:, 1:] > parts[:, :-1]).tobytes().hex()


def film_codes(readers: Mapping[str, Any]) -> dict[str, str]:
    """Return the codes of the films of views, by the views' names."""
    return {name: film_code(r.source) for name, r in readers.items() if hasattr(r, "source")}


def tell_other_films(
    now: Mapping[str, str], made_in: Mapping[str, Collection[str]], *, start: str = "clicks"
) -> list[str]:
    """Say which views show another film than that in which their start was made.

    Parameters
    ----------
    now : mapping of str to str
        Of each view, the code of its film.
    made_in : mapping of str to collection of str
        Of each view, the codes of the films in which its start was made, as far as known.
    start : str
        What the start is made of, in the plural: clicks or poses.

    Returns
    -------
    list of str
        A sentence for each such view.
    """
    said = []
    for view, code in now.items():
        # a start may have been made both before films were exchanged and after
        if max(_bits_apart(code, made_in.get(view, ())), default=0) < _UNLIKE_BITS:
            continue
        alike = [
            other
            for other, codes in made_in.items()
            if other != view
            and min(_bits_apart(code, codes), default=_PARTS_ACROSS * _PARTS_ACROSS) <= _ALIKE_BITS
        ]
        another = f"the {start} of view {view} were made in another film than it shows now"
        if alike:
            said.append(
                f"{another}: it shows the film of {' and '.join(alike)}; films were exchanged or "
                "renamed since, so give each view its own film again, or make the "
                f"{start} of both anew"
            )
        else:
            said.append(
                f"{another}, and may not lie on the animal: the file or its name in trial.toml was "
                f"changed since, so put the film back, or make the {start} anew"
            )
    return said


def _bits_apart(code: str, others: Collection[str]) -> list[int]:
    """Return in how many bits a code differs from each of others; empty where that is unknown."""
    known = [other for other in others if _CODE.fullmatch(other)] if _CODE.fullmatch(code) else []
    return [(int(code[1:], 16) ^ int(other[1:], 16)).bit_count() for other in known]
