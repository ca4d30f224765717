"""What a synthetic spider's recording looks like: settings, three presets, one individual.

The arena, camera and animal are those of Pullar 2009: 40 x 10 cm of glass lit from below,
1280 x 1024 px at 125 frames a second with a shutter of 1/625 s (§2.2), *Dolomedes aquaticus*
(Tables 3.1 and 3.2). Places are in mm of the picture: X to the right and Y down from its
top-left corner, Z up from the panel towards the camera.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np

from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.species_file import load_species
from pawnb.errors import InputError, did_you_mean

FULL_WIDTH, FULL_HEIGHT = 1280, 1024
PX_PER_MM = 4.84
"""Scale of the full picture; §4.1 gives 0.557 px = 0.023 cm at half of it."""

FPS = 125.0
SHUTTER_S = 1.0 / 625.0
ARENA_WIDTH_MM = 100.0
EMPTY_FRAMES = 10
"""Frames before the animal comes in."""

SPECIES = "dolomedes"
MOTIONS = ("run", "still", "drift")
DRIFT_PX = 0.1
"""How far a drifting animal moves from one frame to the next, px of the picture as rendered."""


@dataclass(frozen=True, kw_only=True)
class SpiderScene:
    """Everything that varies from one rendered recording to the next.

    Parameters
    ----------
    seed : int
        Seed of everything that is random; the same seed gives the same recording.
    scale : float
        Size of the picture: 1 is 1280 x 1024 px.
    motion : {"run", "still", "drift"}
        A run through the arena, or one posture held.
    speed_mm_s : tuple of float
        Range of the running speed.
    stance_travel : tuple of float
        Range of how far the body moves over a standing foot, units of the species file.
    phase_sd : float
        Standard deviation of each landing about its place in the gait, cycles; that of the
        first legs is twice as large.
    placement_sd_mm : float
        Standard deviation of where a foot is put down.
    crowding : float
        0 keeps neighbouring feet apart as the animal usually does; 1 brings their tracks so
        close that legs touch and cross.
    bend_share : float
        How strongly the joints bend within a stride; 1 is about half of Table 4.6's ranges.
    off_centre_mm : tuple of float
        Range of the distance of the animal's path from the middle of the arena.
    light, vignetting : float
        Grey level of the panel's middle, and its relative fall towards the corners.
    tip_density : float
        Optical density of the tip of a leg; that of the body is about 4.
    read_noise, shot_noise : float
        Sensor noise in grey levels: the part that is always there, and the part at 255,
        which grows as the square root of the signal.
    flicker : float
        Relative standard deviation of the lamps' brightness from frame to frame.
    blur_px : float
        Standard deviation of the optical blur at scale 1.
    grid, reflection : float
        Relative darkness of the lines of the 1 cm grid, and strength of the walls' mirror image.
    specks : int
        Debris on the panel.
    shadow : float
        Relative darkness of a shadow that drifts over the panel.
    """

    seed: int = 0
    scale: float = 0.5
    motion: str = "run"
    speed_mm_s: tuple[float, float] = (140.0, 165.0)
    stance_travel: tuple[float, float] = (14.2, 15.0)
    phase_sd: float = 0.02
    placement_sd_mm: float = 0.8
    crowding: float = 0.0
    bend_share: float = 1.0
    off_centre_mm: tuple[float, float] = (3.0, 14.0)
    light: float = 200.0
    vignetting: float = 0.35
    tip_density: float = 1.0
    read_noise: float = 1.8
    shot_noise: float = 3.0
    flicker: float = 0.002
    blur_px: float = 0.9
    grid: float = 0.07
    reflection: float = 0.35
    specks: int = 14
    shadow: float = 0.0

    @property
    def width(self) -> int:
        """Width of the picture in px."""
        return round(FULL_WIDTH * self.scale)

    @property
    def height(self) -> int:
        """Height of the picture in px."""
        return round(FULL_HEIGHT * self.scale)

    @property
    def px_per_mm(self) -> float:
        """Scale of the picture."""
        return PX_PER_MM * self.scale

    def rng(self, part: int) -> np.random.Generator:
        """Return the random numbers of one part of the scene."""
        return np.random.default_rng([self.seed, 9, part])


_PRESETS: dict[str, dict[str, Any]] = {
    "easy": {
        "speed_mm_s": (125.0, 145.0),
        "stance_travel": (12.5, 13.3),
        "phase_sd": 0.01,
        "placement_sd_mm": 0.4,
        "crowding": 0.0,
        "bend_share": 0.7,
        "off_centre_mm": (0.0, 5.0),
        "vignetting": 0.2,
        "tip_density": 1.7,
        "read_noise": 1.0,
        "shot_noise": 1.5,
        "flicker": 0.001,
        "blur_px": 0.7,
        "grid": 0.04,
        "reflection": 0.2,
        "specks": 4,
    },
    "normal": {},
    "hard": {
        "speed_mm_s": (185.0, 220.0),
        "stance_travel": (16.5, 17.5),
        "phase_sd": 0.035,
        "placement_sd_mm": 1.4,
        "crowding": 0.25,
        "bend_share": 1.25,
        "off_centre_mm": (15.0, 21.0),
        "light": 180.0,
        "vignetting": 0.5,
        "tip_density": 0.6,
        "read_noise": 3.0,
        "shot_noise": 5.0,
        "flicker": 0.006,
        "blur_px": 1.2,
        "grid": 0.1,
        "reflection": 0.5,
        "specks": 40,
        "shadow": 0.2,
    },
}


def spider_scene(
    difficulty: str = "normal", *, scale: float = 0.5, seed: int = 0, motion: str = "run"
) -> SpiderScene:
    """Return one of the presets.

    Parameters
    ----------
    difficulty : {"easy", "normal", "hard"}
        How quiet and clear the picture, how regular the gait, how far legs keep apart.
    scale : float
        1 is 1280 x 1024 px.
    seed : int
        Another seed is another animal, run and panel.
    motion : {"run", "still", "drift"}
        What the animal does.

    Returns
    -------
    SpiderScene
        The settings.

    Raises
    ------
    InputError
        For an unknown preset or motion, or a scale or seed that makes no sense.
    """
    for what, value, known in (
        ("difficulty", difficulty, tuple(_PRESETS)),
        ("motion", motion, MOTIONS),
    ):
        if value not in known:
            raise InputError(
                f"{what} is {value!r}{did_you_mean(value, known)}; expected {', '.join(known)}."
            )
    if not 0.1 <= scale <= 2.0:
        raise InputError(f"scale is {scale}; expected 0.1 to 2 (1 is 1280 x 1024 px).")
    if seed < 0:
        raise InputError(f"seed is {seed}; expected 0 or a positive whole number.")
    settings = SpiderScene(**_PRESETS[difficulty])
    return dataclasses.replace(settings, scale=scale, seed=seed, motion=motion)


@dataclass(frozen=True)
class Individual:
    """One animal.

    Attributes
    ----------
    animal : StickAnimal
        Species file's lengths with this individual's legs a little longer or shorter.
    size : float
        mm per unit of the species file's lengths.
    thickness, girth : float
        Thickness of its legs and width of its body, relative to the species file.
    grey : float
        Grey level of its cuticle as the camera sees it.
    """

    animal: StickAnimal
    size: float
    thickness: float
    girth: float
    grey: float


def draw_individual(scene: SpiderScene) -> Individual:
    """Draw the animal of a scene.

    Parameters
    ----------
    scene : SpiderScene
        The scene.

    Returns
    -------
    Individual
        Body lengths of 22 to 25 mm: §4.2.1's animals are a little smaller than the model's.
    """
    rng = scene.rng(1)
    species = load_species(SPECIES)
    factors = {}
    for left, right in species.mirrored_names().items():
        if left < right:
            pair = 1.0 + 0.02 * np.clip(rng.standard_normal(), -2, 2)
            for leg in (left, right):
                factors[leg] = float(pair * (1.0 + 0.008 * np.clip(rng.standard_normal(), -2, 2)))
    for segment in species.segments:
        factors[segment] = float(1.0 + 0.01 * np.clip(rng.standard_normal(), -2, 2))
    return Individual(
        animal=species.resized(factors),
        size=float(rng.uniform(0.79, 0.9)),
        thickness=float(rng.uniform(0.85, 1.1)),
        girth=float(rng.uniform(0.95, 1.05)),
        grey=float(rng.uniform(24.0, 40.0)),
    )
