"""Smooth surfaces of animals: tubes swept along a line, joined into one triangle mesh."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from pawnb.arrays import FloatArray, IntArray


@dataclass
class Mesh:
    """Triangles of a whole animal; positions change from frame to frame, the rest does not.

    Attributes
    ----------
    vertices, normals : ndarray (n, 3)
        Positions in mm and outward unit normals.
    colour : ndarray (n, 3)
        RGB, 0-255, before shading.
    surface : ndarray (n, 2)
        Coordinates on the skin in mm: along the part and around it. A texture
        looked up with them moves with the animal.
    fur : ndarray (n,)
        1 on fur, 0 on bare skin.
    faces : ndarray (m, 3)
        Corners of each triangle.
    part : ndarray (m,)
        Number of the body part that the triangle belongs to.
    """

    vertices: np.ndarray
    normals: np.ndarray
    colour: np.ndarray
    surface: np.ndarray
    fur: np.ndarray
    faces: np.ndarray
    part: np.ndarray


@dataclass
class MeshBuilder:
    """Collects parts; what does not move is worked out in the first frame and kept."""

    _vertices: list[np.ndarray] = field(default_factory=list)
    _normals: list[np.ndarray] = field(default_factory=list)
    _fixed: list[tuple[np.ndarray, ...]] = field(default_factory=list)
    _number: int = 0
    _count: int = 0
    _kept: tuple[np.ndarray, ...] | None = None

    def add(
        self,
        part: int,
        vertices: FloatArray,
        normals: FloatArray,
        *,
        fixed: Callable[[], tuple[np.ndarray, ...]],
    ) -> None:
        """Add a part.

        Parameters
        ----------
        part : int
            Its number.
        vertices, normals : ndarray (n, 3)
            For this frame.
        fixed : callable
            Returns (faces, colour, surface, fur); called in the first frame only.
        """
        self._vertices.append(vertices)
        self._normals.append(normals)
        if self._kept is None:
            faces, colour, surface, fur = fixed()
            self._fixed.append(
                (faces + self._count, np.full(len(faces), part), colour, surface, fur)
            )
        self._count += len(vertices)

    @property
    def count(self) -> int:
        """Vertices that were added in this frame."""
        return self._count

    def mesh(self) -> Mesh:
        """Return the mesh of this frame and make ready for the next."""
        if self._kept is None:
            self._kept = tuple(np.concatenate(items) for items in zip(*self._fixed, strict=True))
        faces, part, colour, surface, fur = self._kept
        mesh = Mesh(
            vertices=np.concatenate(self._vertices),
            normals=np.concatenate(self._normals),
            colour=colour,
            surface=surface,
            fur=fur,
            faces=faces,
            part=part,
        )
        self._vertices, self._normals, self._count = [], [], 0
        return mesh


def unit(vector: FloatArray) -> FloatArray:
    """Scale vectors (..., 3) to length 1."""
    length = np.sqrt(np.einsum("...i,...i->...", vector, vector))
    return vector / np.maximum(length, 1e-12)[..., None]


def swept_tube(
    line: FloatArray,
    side: FloatArray,
    radii: tuple[FloatArray, FloatArray],
    *,
    segments: int,
    axis: FloatArray | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Sweep an ellipse along a line.

    Parameters
    ----------
    line : ndarray (r, 3)
        Centres of the rings.
    side : ndarray (3,) or (r, 3)
        Direction of the first half-axis; made perpendicular to the line.
    radii : tuple of ndarray (r,)
        Half-axes along ``side`` and perpendicular to it.
    segments : int
        Corners of each ring.
    axis : ndarray (3,), optional
        Direction of the line where the centres do not tell it, as in a cup.

    Returns
    -------
    vertices, normals : ndarray (r * segments, 3)
        The first corner of each ring is on ``side``; the second half-axis comes a
        quarter of the ring later.
    """
    tangent = unit(np.gradient(line, axis=0)) if axis is None else np.tile(axis, (len(line), 1))
    along = np.einsum("...i,...i->...", tangent, np.broadcast_to(side, line.shape))
    first = unit(side - along[:, None] * tangent)
    second = np.cross(first, tangent)
    angle = np.arange(segments) * (2 * np.pi / segments)
    a, b = (np.asarray(r)[:, None] for r in radii)
    offset = (a * np.cos(angle))[..., None] * first[:, None] + (b * np.sin(angle))[
        ..., None
    ] * second[:, None]
    grid = line[:, None] + offset
    around = np.roll(grid, -1, axis=1) - np.roll(grid, 1, axis=1)
    forward = np.gradient(grid, axis=0)
    normal = unit(np.cross(forward, around))
    return grid.reshape(-1, 3), normal.reshape(-1, 3)


def tube_faces(rings: int, segments: int) -> IntArray:
    """Return the triangles (m, 3) of a swept tube."""
    r, s = np.meshgrid(np.arange(rings - 1), np.arange(segments), indexing="ij")
    here, beside = r * segments + s, r * segments + (s + 1) % segments
    quads = np.stack([here, here + segments, beside + segments, beside], axis=-1).reshape(-1, 4)
    return np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])


def tube_surface(lengths: FloatArray, girth: float, segments: int) -> FloatArray:
    """Return skin coordinates (r * segments, 2) in mm for rings at some lengths.

    Parameters
    ----------
    lengths : ndarray, shape (r,)
        Where the rings are along the tube, mm.
    girth : float
        Way round a ring, mm.
    segments : int
        Corners of a ring.

    Returns
    -------
    ndarray, shape (r * segments, 2)
        Skin coordinates, mm.
    """
    around = np.arange(segments) * (girth / segments)
    # there and back, so that the texture has no seam where the ring closes
    around = girth / 2 - np.abs(around - girth / 2)
    along, beside = np.meshgrid(lengths, around, indexing="ij")
    return np.stack([along, beside], axis=-1).reshape(-1, 2)


def rounded(radii: FloatArray) -> FloatArray:
    """Return radii with the ends closed by a rounded cap (first and last two rings)."""
    out = np.array(radii, dtype=float)
    out[[0, -1]] *= 0.05
    out[[1, -2]] *= 0.8
    return out


def rotation(roll: float, pitch: float, yaw: float) -> FloatArray:
    """Return the matrix that turns (forward, left, up) by roll, then pitch, then yaw, in rad.

    Positive pitch lifts the head, positive yaw turns it to the left.

    Parameters
    ----------
    roll, pitch, yaw : float
        Angles, rad.

    Returns
    -------
    ndarray, shape (3, 3)
        The matrix.
    """
    cr, sr, cp, sp, cy, sy = (f(x) for x in (roll, pitch, yaw) for f in (np.cos, np.sin))
    about_forward = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    about_left = np.array([[cp, 0, -sp], [0, 1, 0], [sp, 0, cp]])
    about_up = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    return about_up @ about_left @ about_forward
