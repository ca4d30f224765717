"""Points, trails and legs drawn over a picture, as the reviewers show them."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import matplotlib as mpl
import numpy as np
from PIL import Image, ImageDraw, ImageFont

from pawnb.errors import InputError
from pawnb.schema import ORIGINS, Tracks
from pawnb.workflow.export.colours import point_colours

TRAIL = 20
"""Frames of the past that a trail shows, as in the reviewers."""

Colour = tuple[int, int, int]
"""Red, green and blue, 0 to 255."""

_BITS = 4  # of a pixel, for cv2: what it draws falls between pixels
_RADIUS_PX, _TEXT_PX = (3, 7), (10, 14)
"""Of rings and of names, in a small picture and in a large one."""
_LARGE_PX = 700
"""Width of a picture that is large."""
_NAME_PLACES = ((9, -20), (9, 6), (-9, -20), (-9, 6), (14, -36), (-14, 22))
"""Where a name stands beside its point in a large picture, px: the first place that is free."""
_DARK_SHARE = 0.2
"""Relative luminance below which a mark has a white rim."""


@dataclass(frozen=True)
class Marks:
    """Where the points of tracks are in the pictures.

    Parameters
    ----------
    frames : ndarray, shape (n,)
        Frames of the tracks.
    views, points : tuple of str
        Names, in the order of the arrays.
    uv : ndarray, shape (n, V, 2, P)
        Image positions, px.
    origin : ndarray, shape (n, V, P)
        Codes of :data:`pawnb.schema.ORIGINS`.
    colours : tuple of (red, green, blue)
        0 to 255, of each point.
    chains : tuple of tuple of int
        Joints that a leg joins, from the body outwards: places in ``points``.
    """

    frames: np.ndarray
    views: tuple[str, ...]
    points: tuple[str, ...]
    uv: np.ndarray
    origin: np.ndarray
    colours: tuple[Colour, ...]
    chains: tuple[tuple[int, ...], ...]

    @classmethod
    def of_tracks(cls, tracks: Tracks) -> Marks:
        """Take them out of Tracks of one animal; raises InputError where they have none."""
        if "image_position" not in tracks or tracks.sizes["individual"] != 1:
            raise InputError(
                "these tracks are not those of one animal with positions in its pictures; export "
                "tracks that were made from video, one animal at a time."
            )
        points = tuple(str(name) for name in tracks["keypoint"].to_numpy())
        chains = _legs(points)
        named = point_colours([point for point in points if "." not in point])
        colours = [named[point.partition(".")[0]] for point in points]
        return cls(
            frames=tracks["frame"].to_numpy(),
            views=tuple(str(name) for name in tracks["view"].to_numpy()),
            points=points,
            uv=tracks["image_position"].transpose(
                "time", "view", "image_space", "keypoint", "individual"
            ).to_numpy()[..., 0],
            origin=tracks["image_origin"].transpose(
                "time", "view", "keypoint", "individual"
            ).to_numpy()[..., 0],
            colours=tuple(rgb(colour) for colour in colours),
            chains=chains,
        )  # fmt: skip

    def draw(
        self, image: np.ndarray, view: str, frame: int, *, scale: float, trail: int = TRAIL
    ) -> None:
        """Draw the points of one frame over the picture of a view.

        Parameters
        ----------
        image : ndarray, shape (H, W, 3), uint8
            The picture, RGB; drawn upon.
        view : str
            Its view.
        frame : int
            The frame; one without tracks is left as it is.
        scale : float
            Pixels of ``image`` for one of the view.
        trail : int
            Frames of the past that trails show.
        """
        rows = np.flatnonzero(self.frames == frame)
        if view not in self.views or not len(rows):
            return
        row, k = int(rows[0]), self.views.index(view)
        past = self.uv[max(0, row - trail) : row + 1, k]  # (m, 2, P)
        places = (past + 0.5) * scale - 0.5
        inner = {p for chain in self.chains for p in chain[:-1]}
        for p, colour in enumerate(self.colours):
            if p not in inner:
                line(image, places[:, :, p], colour, width=1)
        for chain in self.chains:
            line(image, places[-1][:, chain].T, self.colours[chain[-1]], width=2)
        tips = [p for p in range(len(self.points)) if p not in inner]
        shown = [p for p in tips if np.isfinite(places[-1, :, p]).all()]
        for p in shown:
            ring(image, places[-1, :, p], self.colours[p], origin=ORIGINS[self.origin[row, k, p]])
        if shown:
            write_beside(
                image, [(self.points[p], places[-1, :, p], self.colours[p]) for p in shown]
            )


def rgb(colour: str) -> Colour:
    """Return ``#rrggbb`` as red, green and blue."""
    red, green, blue = bytes.fromhex(colour[1:])
    return red, green, blue


def write(image: np.ndarray, words: Sequence[tuple[str, np.ndarray, Colour]]) -> None:
    """Write words over a picture, with a rim.

    Parameters
    ----------
    image : ndarray, shape (H, W, 3), uint8
        The picture; written upon.
    words : sequence of (text, ndarray, colour)
        What, its left upper corner in px, and red, green, blue. It is moved into the picture.
    """
    canvas = Image.fromarray(image)
    pen, font = ImageDraw.Draw(canvas), _font(_sized(image, _TEXT_PX))
    for text, at, colour in words:
        left, top, right, bottom = pen.textbbox((0, 0), text, font=font, stroke_width=2)
        room = np.array([canvas.width - right, canvas.height - bottom], float)
        u, v = np.maximum(np.minimum(at, room), (-left, -top))
        pen.text((u, v), text, font=font, fill=colour, stroke_width=2, stroke_fill=_rim(colour))
    image[:] = np.asarray(canvas)


def write_beside(image: np.ndarray, names: Sequence[tuple[str, np.ndarray, Colour]]) -> None:
    """Write names beside points, where they cover neither a point nor another name.

    Parameters
    ----------
    image : ndarray, shape (H, W, 3), uint8
        The picture; written upon.
    names : sequence of (text, ndarray, colour)
        What, the point in px, and red, green, blue.
    """
    font, radius = _font(_sized(image, _TEXT_PX)), _sized(image, _RADIUS_PX)
    taken = [np.concatenate([at - radius, at + radius]) for _, at, _ in names]
    words = []
    for text, at, colour in names:
        left, top, right, bottom = font.getbbox(text, stroke_width=1)
        places = []
        for du, dv in np.array(_NAME_PLACES) * (radius / _RADIUS_PX[1]):
            u = at[0] + du if du > 0 else at[0] + du - right
            places.append(np.array([u + left, at[1] + dv + top, u + right, at[1] + dv + bottom]))
        free = [place for place in places if not any(_overlap(place, other) for other in taken)]
        chosen = (free or places)[0]
        taken.append(chosen)
        words.append((text, chosen[:2] - (left, top), colour))
    write(image, words)


def _overlap(box: np.ndarray, other: np.ndarray) -> bool:
    """Say whether two boxes (left, top, right, bottom) overlap."""
    return bool((box[:2] < other[2:]).all() and (other[:2] < box[2:]).all())


def _sized(image: np.ndarray, sizes: tuple[int, int]) -> int:
    """Return the size of what is drawn over a picture, between that of small and large ones."""
    small, large = sizes
    return round(min(large, max(small, large * image.shape[1] / _LARGE_PX)))


def _legs(points: tuple[str, ...]) -> tuple[tuple[int, ...], ...]:
    """Return the joints of each leg, its tip last: points ``L1.BC``, ``L1.CT`` and ``L1``."""
    tips = [point for point in points if any(one.startswith(f"{point}.") for one in points)]
    return tuple(
        (*(k for k, one in enumerate(points) if one.startswith(f"{tip}.")), points.index(tip))
        for tip in tips
    )


def line(image: np.ndarray, at: np.ndarray, colour: Colour, *, width: int) -> None:
    """Draw a line, with a rim and with gaps where a place is not known.

    Parameters
    ----------
    image : ndarray, shape (H, W, 3), uint8
        The picture; drawn upon.
    at : ndarray, shape (m, 2)
        Its places, px.
    colour : tuple of int
        Red, green and blue.
    width : int
        In px.
    """
    known = np.isfinite(at).all(axis=1)
    ends = [(at[i], at[i + 1]) for i in range(len(at) - 1) if known[i] and known[i + 1]]
    for thick, ink in ((width + 2, _rim(colour)), (width, colour)):
        for a, b in ends:
            cv2.line(image, _fixed(a), _fixed(b), ink, thick, cv2.LINE_AA, _BITS)


def ring(image: np.ndarray, at: np.ndarray, colour: Colour, *, origin: str) -> None:
    """Draw a ring: thin where only predicted or reprojected, doubled where placed by hand.

    Parameters
    ----------
    image : ndarray, shape (H, W, 3), uint8
        The picture; drawn upon.
    at : ndarray, shape (2,)
        Its middle, px.
    colour : tuple of int
        Red, green and blue.
    origin : str
        One of :data:`pawnb.schema.ORIGINS`.
    """
    size = _sized(image, _RADIUS_PX)
    radii = [size, size + 4] if origin == "edited" else [size]
    width = 1 if origin in ("predicted", "reprojected") else 2
    for radius in radii:
        for thick, ink in ((width + 2, _rim(colour)), (width, colour)):
            cv2.circle(image, _fixed(at), radius << _BITS, ink, thick, cv2.LINE_AA, _BITS)


def _fixed(at: np.ndarray) -> tuple[int, int]:
    """Return a place as cv2 takes it; one far outside is as far as it can be told."""
    u, v = np.clip(np.round(at * (1 << _BITS)), -(2**24), 2**24).astype(int)
    return int(u), int(v)


def _rim(colour: Colour) -> Colour:
    """Return white around dark colours and black around light ones."""
    red, green, blue = ((part / 255) ** 2.2 for part in colour)
    dark = 0.2126 * red + 0.7152 * green + 0.0722 * blue < _DARK_SHARE
    return (255, 255, 255) if dark else (0, 0, 0)


@functools.cache
def _font(size_px: int) -> ImageFont.FreeTypeFont:
    """Return a font that knows more than Latin letters: matplotlib brings it."""
    return ImageFont.truetype(f"{mpl.get_data_path()}/fonts/ttf/DejaVuSans.ttf", size_px)
