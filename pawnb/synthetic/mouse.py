"""The body of the synthetic mouse at any moment, as one triangle mesh."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.synthetic import anatomy
from pawnb.synthetic.anatomy import Limb, tail_line, two_links
from pawnb.synthetic.covered_paws import cover_paws
from pawnb.synthetic.gait_model import Gait
from pawnb.synthetic.hair import Hairs, draw_hairs, hair_triangles
from pawnb.synthetic.scene import LEGS, SceneSettings
from pawnb.synthetic.surfaces import (
    Mesh,
    MeshBuilder,
    rotation,
    rounded,
    swept_tube,
    tube_faces,
    tube_surface,
    unit,
)

BODY, LIMB, TAIL, EAR, EYE, HAIR = range(6)
PAW = {leg: 10 + number for number, leg in enumerate(LEGS)}
"""Number of each paw among the parts of the mesh: the whole front paw from the wrist,
the hind paw from the distal part of the metatarsus, each with its digits."""

TWO_SIDED = (HAIR,)

_TAIL_RINGS, _TAIL_SEGMENTS = 36, 10
_SHAFT_RINGS, _SHAFT_SEGMENTS = 27, 16
_HAIRS, _LIMB_HAIRS, _WHISKERS = 3600, 350, 12


LANDMARKS = ("nose", "ear_L", "ear_R", "tail_base", "tail_tip")
"""Points of the body whose places are known, besides the paws."""

_EAR = np.array([29.5, 7.6, 33.0])


@dataclass
class _Pose:
    """The body frame at one moment: ``place`` takes body coordinates to the laboratory."""

    turn: FloatArray
    origin: FloatArray
    beat: float

    def place(self, points: FloatArray) -> FloatArray:
        """Return laboratory (forward, left, up) of points in the body frame."""
        return points @ self.turn.T + self.origin


class Mouse:
    """A mouse that runs a given gait.

    Parameters
    ----------
    settings : SceneSettings
        Size and colours.
    gait : Gait
        How it runs.
    """

    def __init__(self, settings: SceneSettings, gait: Gait) -> None:
        self._settings = settings
        self._gait = gait
        self._builder = MeshBuilder()
        self._profile = anatomy.trunk_profile()
        self._posture = {
            limb: (anatomy.posture(limb.pitch_deg), anatomy.posture(limb.toe_deg))
            for limb in (anatomy.FRONT, anatomy.HIND)
        }
        self._fur = np.array(settings.fur_rgb)
        self._skin = np.array(settings.paw_rgb)
        size = settings.size
        rng = np.random.default_rng([settings.seed, 3])
        self._hairs = draw_hairs(
            rng,
            _HAIRS,
            rings=(2.0, anatomy.TRUNK_RINGS - 12.0),
            segments=anatomy.TRUNK_SEGMENTS,
            size=size,
        )
        furred = (1.0, 0.6 * _SHAFT_RINGS)
        self._limb_hairs = {
            leg: draw_hairs(rng, _LIMB_HAIRS, rings=furred, segments=_SHAFT_SEGMENTS, size=size)
            for leg in LEGS
        }

    def mesh(self, time_s: float) -> Mesh:
        """Return the animal at a time, in laboratory X, Y, Z (mm)."""
        pose = self._pose(time_s)
        trunk = self._add_trunk(pose)
        self._add_hairs(*trunk, self._hairs, -1.0)
        self._add_head(pose)
        self._add_tail(pose, time_s)
        limbs, phases = {}, {}
        for leg in LEGS:
            first = self._builder.count
            phases[leg] = self._add_limb(leg, pose, time_s)
            limbs[leg] = slice(first, self._builder.count)
        mesh = self._builder.mesh()
        if self._settings.covered_paws:
            mesh = cover_paws(mesh, limbs, phases, settings=self._settings)
        # forward and left become +X and +Y, or -X and -Y
        facing = np.array([self._settings.direction, self._settings.direction, 1.0])
        mesh.vertices = mesh.vertices * facing
        mesh.normals = mesh.normals * facing
        return mesh

    def landmarks(self, time_s: float) -> FloatArray:
        """Return the landmarks at a time, shape (5, 3), mm, in the order of LANDMARKS.

        The tip of the nose, the middle of each ear, and the base and the tip of the tail.
        """
        pose = self._pose(time_s)
        forward, height, *_ = self._profile[-1]
        head = np.array([[forward, 0.0, height], *(_EAR * [1.0, side, 1.0] for side in (1, -1))])
        tail = self._tail(pose, time_s)[[0, -1]]
        placed = pose.place(np.vstack([self._flex(head, pose), tail]))
        placed[3:, 2] = np.maximum(placed[3:, 2], 1.0)  # as the tail is drawn
        return placed * [self._settings.direction, self._settings.direction, 1.0]

    def _pose(self, time_s: float) -> _Pose:
        """Read the body's place from the gait; it turns about a point amid the trunk."""
        body = self._gait.body
        now = np.array(time_s)
        value = {
            n: float(body.value(n, now)) for n in ("forward", "left", "up", "pitch", "roll", "yaw")
        }
        turn = rotation(value["roll"], value["pitch"], value["yaw"])
        size = self._settings.size
        pivot = np.array([0.0, 0.0, 22.0]) * size
        origin = np.array([value["forward"], value["left"], value["up"]]) + pivot - turn @ pivot
        beat = 2 * np.pi * float(body.cycles(now))
        return _Pose(turn=turn * size, origin=origin, beat=beat)

    def _flex(self, points: FloatArray, pose: _Pose) -> FloatArray:
        """Bend the spine sideways with the stride and nod the head (body frame)."""
        out = points.copy()
        out[:, 1] += 0.9 * np.sin(pose.beat) * (points[:, 0] / 35.0) ** 2
        weight = np.clip((points[:, 0] - 20.0) / 16.0, 0.0, 1.0)
        out[:, 2] += weight * (0.5 * np.sin(2 * pose.beat + 0.8))
        return out

    def _add_trunk(self, pose: _Pose) -> tuple[FloatArray, FloatArray]:
        """Add trunk and head; return vertex and normal grids (rings, segments, 3)."""
        rings, segments = anatomy.TRUNK_RINGS, anatomy.TRUNK_SEGMENTS
        forward, height, tall, wide = self._profile.T
        line = np.column_stack([forward, np.zeros(rings), height])
        vertices, _ = swept_tube(
            line, np.array([0.0, 1.0, 0.0]), (wide, tall), segments=segments,
            axis=np.array([1.0, 0.0, 0.0]),
        )  # fmt: skip
        # wider below than above, as a mouse is
        relative = (vertices[:, 2] - np.repeat(height, segments)) / np.repeat(tall, segments)
        vertices[:, 1] *= 1.0 - 0.15 * relative
        vertices = pose.place(self._flex(vertices, pose))
        grid = vertices.reshape(rings, segments, 3)
        around = np.roll(grid, -1, axis=1) - np.roll(grid, 1, axis=1)
        normals = unit(np.cross(np.gradient(grid, axis=0), around))

        def fixed() -> tuple[np.ndarray, ...]:
            colour = np.tile(self._fur, (rings * segments, 1))
            ahead = np.repeat(forward, segments)
            below = np.clip(-relative - 0.2, 0.0, 1.0)[:, None]
            colour += below * 0.18 * (np.array([120.0, 115.0, 105.0]) - colour)
            muzzle = np.clip((ahead - 43.0) / 5.0, 0.0, 1.0)[:, None]
            colour += muzzle * 0.12 * (self._skin - colour)
            nose = np.clip((ahead - 49.2) / 0.5, 0.0, 1.0)[:, None]
            colour += nose * 0.9 * (self._skin - colour)
            fur = 1.0 - nose[:, 0]
            girth = 2 * np.pi * 13.0
            return (
                tube_faces(rings, segments), colour, tube_surface(forward, girth, segments), fur,
            )  # fmt: skip

        self._builder.add(BODY, vertices, normals.reshape(-1, 3), fixed=fixed)
        return grid, normals

    def _add_hairs(self, grid: FloatArray, normals: FloatArray, hairs: Hairs, way: float) -> None:
        """Add the hairs of a part with rings of corners ``grid`` (rings, segments, 3)."""
        vertices, lit = hair_triangles(
            grid, normals.reshape(grid.shape), hairs, way=way, width=0.34 * self._settings.size
        )

        def fixed() -> tuple[np.ndarray, ...]:
            n = len(vertices)
            colour = np.repeat(self._fur * hairs.shade[:, None], 3, axis=0)
            return np.arange(n).reshape(-1, 3), colour, np.zeros((n, 2)), np.zeros(n)

        self._builder.add(HAIR, vertices, lit, fixed=fixed)

    def _add_head(self, pose: _Pose) -> None:
        """Add ears, eyes and whiskers."""
        for side in (1.0, -1.0):
            outward = unit(np.array([0.42, side * 0.80, 0.42]))
            centre = _EAR * [1.0, side, 1.0]
            offset = np.array([-1.3, -1.1, -0.7, 0.3, 0.5, 0.0, -0.5, -0.7])
            radius = np.array([0.02, 2.8, 4.6, 5.6, 5.4, 4.2, 2.4, 0.02])
            line = self._flex(centre + offset[:, None] * outward, pose)
            vertices, normals = swept_tube(
                line, np.array([-0.5, 0.0, 1.0]), (radius * 1.15, radius), segments=18,
                axis=outward,
            )  # fmt: skip
            inner = np.repeat(np.linspace(0.0, 1.0, 8) > 0.5, 18)[:, None]
            # darker towards the opening at the foot of the cup, paler to the rim
            around = np.cos(np.arange(18) * (2 * np.pi / 18))
            rim = 0.5 + 0.5 * np.outer(radius / 5.6, around).reshape(-1, 1)
            skin = 0.55 * self._skin + 0.45 * self._skin.mean()
            colour = skin * np.where(inner, 0.58 + 0.42 * rim, 0.65 + 0.3 * rim)
            self._add_tube(EAR, pose.place(vertices), normals @ pose.turn.T, colour, 18)
            middle = np.array([38.4, side * 6.6, 23.2])
            ball = np.linspace(-1.0, 1.0, 8)
            bulge = 1.5 * np.sqrt(np.maximum(1.0 - ball**2, 0.02))
            aim = unit(np.array([0.35, side, 0.25]))
            line = self._flex(middle + 1.5 * ball[:, None] * aim, pose)
            vertices, normals = swept_tube(
                line, np.array([1.0, 0.0, 0.0]), (bulge, bulge), segments=10
            )
            dark = np.tile([14.0, 13.0, 14.0], (len(vertices), 1))
            self._add_tube(EYE, pose.place(vertices), normals @ pose.turn.T, dark, 10)
        self._add_whiskers(pose)

    def _add_whiskers(self, pose: _Pose) -> None:
        """Add long pale hairs at the muzzle."""
        number = np.arange(_WHISKERS)
        side = np.where(number % 2 == 0, 1.0, -1.0)
        root = np.column_stack([45.0 - 0.4 * (number // 2), side * 3.6, 16.5 + 0.3 * (number // 4)])
        spread = (number // 2 - 2.5) / 2.5
        aim = unit(np.column_stack([0.1 - 0.35 * spread, side * 1.0, 0.3 * spread - 0.25]))
        root = self._flex(root, pose)
        half = np.array([0.0, 0.0, 0.12])
        tip = root + 13.0 * aim
        vertices = np.stack([root - half, root + half, tip], axis=1).reshape(-1, 3)
        normals = np.tile([0.0, 0.0, 1.0], (len(vertices), 1))

        def fixed() -> tuple[np.ndarray, ...]:
            n = len(vertices)
            pale = np.tile([105.0, 102.0, 96.0], (n, 1))
            return np.arange(n).reshape(-1, 3), pale, np.zeros((n, 2)), np.zeros(n)

        self._builder.add(HAIR, pose.place(vertices), normals, fixed=fixed)

    def _add_tail(self, pose: _Pose, time_s: float) -> None:
        """Add the tail."""
        s = np.linspace(0.0, 1.0, _TAIL_RINGS)
        line = self._tail(pose, time_s)
        radius = rounded(2.2 * (1.0 - s) ** 0.8 + 0.8)
        vertices, normals = swept_tube(
            line, np.array([0.0, 1.0, 0.0]), (radius, radius), segments=_TAIL_SEGMENTS
        )
        shade = np.repeat(0.72 + 0.12 * s, _TAIL_SEGMENTS)[:, None]
        colour = shade * (0.6 * self._skin + 0.4 * self._skin.mean())
        placed = pose.place(vertices)
        placed[:, 2] = np.maximum(placed[:, 2], 1.0)  # it may lie on the belt, not below it
        self._add_tube(TAIL, placed, normals @ pose.turn.T, colour, _TAIL_SEGMENTS)

    def _tail(self, pose: _Pose, time_s: float) -> FloatArray:
        """Return the middle of the tail, base to tip (body frame)."""
        sway = float(self._gait.body.value("yaw", np.array(time_s)))
        return tail_line(
            _TAIL_RINGS, lift_deg=self._settings.tail_lift_deg, beat=pose.beat, sway=sway
        )

    def _add_limb(self, leg: str, pose: _Pose, time_s: float) -> float:
        """Add a limb from its girdle to the digits; return the phase of its step, 0-2.

        The tracked point is where the gait has it.
        """
        limb = anatomy.FRONT if leg[0] == "F" else anatomy.HIND
        side, size = (1.0 if leg[1] == "L" else -1.0), self._settings.size
        motion = self._gait.legs[leg]
        point = motion.position(np.array([time_s]))[0]
        phase = float(motion.phase(np.array([time_s]))[0])
        pitch, toe = (float(curve(phase)) for curve in self._posture[limb])
        forward = unit(pose.turn[:, 0] * [1.0, 1.0, 0.0])
        splay = side * np.radians(limb.splay_deg)
        ahead = rotation(0.0, 0.0, splay) @ forward
        up = np.array([0.0, 0.0, 1.0])
        left = np.cross(up, ahead)
        digit = np.cos(toe) * ahead + np.sin(toe) * up
        pad = point - 0.5 * limb.digits * size * digit
        ankle = pad + limb.foot * size * (-np.cos(pitch) * ahead + np.sin(pitch) * up)
        joint = np.array([limb.joint[0], side * limb.joint[1], limb.joint[2]])
        top = pose.place(joint[None])[0]
        top = top + limb.slide * ((point - top) @ forward) * forward
        lengths = (limb.upper * size, limb.lower * size)
        knee = two_links(top, ankle, lengths=lengths, bend=limb.bend * forward)
        # where the limb is folded the skin of the flank holds the joint
        knee[2] = np.clip(knee[2], size * limb.bend_height[0], size * limb.bend_height[1])
        knee = knee + side * left * (1.5 if limb is anatomy.HIND else 1.0) * size
        self._add_shaft(leg, limb, (top, knee, ankle), left, pose)
        self._add_paw(leg, limb, (ankle, pad, point), digit, left)
        return phase

    def _add_shaft(
        self,
        leg: str,
        limb: Limb,
        joints: tuple[FloatArray, FloatArray, FloatArray],
        left: FloatArray,
        pose: _Pose,
    ) -> None:
        """Add the limb above the foot as one bent tube, furred down to its bare part."""
        top, knee, ankle = joints
        rings, segments, size = _SHAFT_RINGS, _SHAFT_SEGMENTS, self._settings.size
        t = np.linspace(0.0, 1.0, rings)
        u = np.clip(2 * t[:, None], 0, 1), np.clip(2 * t[:, None] - 1, 0, 1)
        line = top + u[0] * (knee - top) + u[1] * (ankle - knee)
        for _ in range(14):  # round the knee
            line[1:-1] = 0.25 * line[:-2] + 0.5 * line[1:-1] + 0.25 * line[2:]
        nodes = np.linspace(0.0, 1.0, len(limb.shaft_width))
        wide, deep = (
            rounded(np.interp(t, nodes, r) * size) for r in (limb.shaft_width, limb.shaft_depth)
        )
        vertices, normals = swept_tube(line, left, (wide, deep), segments=segments)
        # where the limb lies on the flank the skin runs on: take the flank's direction there
        flank = (vertices - pose.origin) @ pose.turn / size**2
        flank = (flank - [0.0, 0.0, 24.0]) * [0.0, 1.0, 0.8] @ pose.turn.T
        lie = np.repeat(np.clip(1.0 - 2.2 * t, 0.0, 0.85), segments)[:, None]
        normals = unit((1.0 - lie) * normals + lie * unit(flank))
        bare = np.repeat(np.clip((t - limb.bare_from) / 0.1, 0.0, 1.0), segments)[:, None]
        colour = self._fur + bare * (0.78 * self._skin - self._fur)
        self._add_tube(
            LIMB, vertices, normals, colour, segments,
            fur=0.45 * (1.0 - bare[:, 0]), lengths=(limb.upper + limb.lower) * t,
        )  # fmt: skip
        grid = vertices.reshape(rings, segments, 3)
        self._add_hairs(grid, normals, self._limb_hairs[leg], 1.0)

    def _add_paw(
        self,
        leg: str,
        limb: Limb,
        places: tuple[FloatArray, FloatArray, FloatArray],
        digit: FloatArray,
        left: FloatArray,
    ) -> None:
        """Add the foot: back part, pad and digits."""
        ankle, pad, point = places
        size, segments = self._settings.size, 12
        t = np.linspace(0.0, 1.0, 9)
        back = ankle + t[:, None] * (pad - ankle)
        line = np.vstack([back, pad + np.array([[0.3], [0.62], [0.8]]) * (2 * (point - pad))])
        share = np.concatenate([0.75 * t, [0.85, 0.97, 1.0]])
        five = np.linspace(0.0, 1.0, 5)
        wide = rounded(np.interp(share, five, limb.foot_width) * size)
        tall = rounded(np.interp(share, five, limb.foot_height) * size)
        vertices, normals = swept_tube(line, left, (wide, tall), segments=segments)
        colour = self._skin * np.repeat(0.86 + 0.14 * share, segments)[:, None]
        first = int(np.searchsorted(t, limb.paw_from))
        cut = first * segments
        if first:
            keep = slice(0, cut + segments)
            self._add_tube(LIMB, vertices[keep], normals[keep], colour[keep], segments)
        self._add_tube(PAW[leg], vertices[cut:], normals[cut:], colour[cut:], segments)
        fan = np.radians(np.linspace(-0.5, 0.5, limb.toe_count) * limb.toe_fan_deg)
        over = np.cross(digit, left)
        s = np.linspace(0.0, 1.0, 6)
        for angle in fan:
            aim = np.cos(angle) * digit + np.sin(angle) * left
            length = limb.digits * size * (1.0 - 0.22 * (abs(angle) / abs(fan[0])) ** 2)
            base = pad + left * (np.sin(angle) * 3.0 * size)
            arch = 0.35 * size * np.sin(np.pi * s)[:, None] * over
            toe = base + s[:, None] * length * aim + arch
            radius = rounded((0.75 - 0.25 * s) * size)
            vertices, normals = swept_tube(toe, left, (radius, radius), segments=6)
            colour = self._skin * np.repeat(0.97 + 0.1 * s, 6)[:, None]
            self._add_tube(PAW[leg], vertices, normals, colour, 6)

    def _add_tube(
        self,
        part: int,
        vertices: FloatArray,
        normals: FloatArray,
        colour: FloatArray,
        segments: int,
        *,
        fur: FloatArray | None = None,
        lengths: FloatArray | None = None,
    ) -> None:
        """Add one swept tube with its colours."""
        rings = len(vertices) // segments

        def fixed() -> tuple[np.ndarray, ...]:
            along = np.arange(rings, dtype=float) if lengths is None else lengths
            skin = tube_surface(along, 25.0, segments)
            bare = np.zeros(rings * segments) if fur is None else fur
            return tube_faces(rings, segments), np.minimum(colour, 255.0), skin, bare

        self._builder.add(part, vertices, unit(normals), fixed=fixed)
