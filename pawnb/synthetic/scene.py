"""What a synthetic treadmill scene looks like: one frozen description, three presets."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any, Literal

from pawnb.errors import InputError, did_you_mean
from pawnb.schema import build_settings

FULL_WIDTH = 2048
FULL_HEIGHT = 700
"""Size in px of a picture at scale 1 (Haji Maghsoudi et al. 2019, section 2.1.1)."""

LEGS = ("FR", "HR", "FL", "HL")


def _limits(default: Any, low: float, high: float) -> Any:
    """Return a dataclass field with the range in which it makes sense."""
    return field(default=default, metadata={"low": low, "high": high})


@dataclass(frozen=True, kw_only=True)
class SceneSettings:
    """Everything that can vary from one rendered recording to the next.

    Lengths are in mm, times in s, colours are RGB from 0 to 255 as they appear
    under the light of the scene. "Forward" is the direction in which the animal
    runs, "left" its own left.

    Parameters
    ----------
    seed : int
        Seed of everything that is random; the same seed gives the same recording.
    scale : float
        Size of the picture: ``round(2048 scale)`` x ``round(700 scale)`` px.
    fps : float
        Frames per second.
    n_views : int
        2, 3 or 4 cameras: two on one side, then those on the other.
    direction : {1, -1}
        Whether the animal runs towards +X or -X.
    belt_speed_mm_s : float
        Speed of the belt, which moves against the animal.
    stride_frequency_hz, duty_factor : float, optional
        Means over strides; without them they follow from the speed.
    period_sd, duty_sd : float
        Standard deviation of the stride period (fraction of its mean) and of the
        duty factor, stride by stride.
    phase_jitter : float
        Standard deviation of each touch-down about its place in the gait, in cycles.
    placement_sd_mm : float
        Standard deviation of where a paw is put down.
    drift_mm, sway_mm : float
        Amplitude of the slow wandering of the body along the belt and across it.
    size : float
        Size of the animal; 1 is 87 mm from the nose to the base of the tail.
    tail_lift_deg : float
        Elevation of the tail.
    belt_rgb, fur_rgb, paw_rgb, backdrop_rgb : tuple of float
        Colours.
    belt_marks : float
        Strength of the marks on the belt; 1 is that of a used, painted belt.
    light : float
        Brightness of the lamps; 1 uses about 60 % of the sensor's range.
    light_azimuth_deg : float
        Where the stronger lamp stands, seen from above, from +X towards +Y.
    light_gradient : float
        Relative fall of the light from the middle of the belt to its ends.
    read_noise, shot_noise : float
        Sensor noise in grey levels: the part that is always there, and the part at
        255, which grows as the square root of the signal.
    blur_px : float
        Standard deviation of the optical blur at scale 1.
    camera_jitter_deg : float
        Standard deviation of each camera's direction about its usual place.
    below : bool
        Whether belt and lamps are those of a treadmill that is filmed from below, through glass.
    shutter : float
        Share of the time between two frames for which the shutter is open.
    flicker : float
        By how much the lamps grow brighter and darker with the mains, relative to their mean.
    reflections : float
        Share of the light that a shining belt reflects; the walls reflect less.
    covered_paws : float
        How much a paw has the colour of the fur that lies over it at lift-off, 0 to 1.
    grey : bool
        Whether the camera is a grey one.
    crf : int, optional
        Quality of H.264, from 0, the best, to 51; without it frames are coded one by one, finely.
    """

    seed: int = _limits(0, 0, 2**32 - 1)
    scale: float = _limits(0.5, 0.05, 2.0)
    fps: float = _limits(250.0, 20.0, 5000.0)
    n_views: int = _limits(4, 2, 4)
    direction: Literal[1, -1] = 1
    belt_speed_mm_s: float = _limits(300.0, 50.0, 900.0)
    stride_frequency_hz: float | None = _limits(None, 1.0, 12.0)
    duty_factor: float | None = _limits(None, 0.5, 0.8)
    period_sd: float = _limits(0.05, 0.0, 0.15)
    duty_sd: float = _limits(0.015, 0.0, 0.04)
    phase_jitter: float = _limits(0.02, 0.0, 0.06)
    placement_sd_mm: float = _limits(1.5, 0.0, 5.0)
    drift_mm: float = _limits(8.0, 0.0, 40.0)
    sway_mm: float = _limits(3.0, 0.0, 15.0)
    size: float = _limits(1.0, 0.7, 1.3)
    tail_lift_deg: float = _limits(50.0, 0.0, 80.0)
    belt_rgb: tuple[float, float, float] = (108.0, 148.0, 108.0)
    fur_rgb: tuple[float, float, float] = (52.0, 53.0, 50.0)
    paw_rgb: tuple[float, float, float] = (178.0, 136.0, 122.0)
    backdrop_rgb: tuple[float, float, float] = (100.0, 101.0, 98.0)
    belt_marks: float = _limits(1.0, 0.0, 4.0)
    light: float = _limits(1.0, 0.3, 1.5)
    light_azimuth_deg: float = _limits(60.0, -360.0, 360.0)
    light_gradient: float = _limits(0.2, 0.0, 0.7)
    read_noise: float = _limits(1.5, 0.0, 20.0)
    shot_noise: float = _limits(4.0, 0.0, 30.0)
    blur_px: float = _limits(0.7, 0.0, 4.0)
    camera_jitter_deg: float = _limits(1.5, 0.0, 5.0)
    below: bool = False
    shutter: float = _limits(0.0, 0.0, 1.0)
    flicker: float = _limits(0.0, 0.0, 0.8)
    reflections: float = _limits(0.0, 0.0, 0.8)
    covered_paws: float = _limits(0.0, 0.0, 1.0)
    grey: bool = False
    crf: int | None = _limits(None, 0, 51)

    def __post_init__(self) -> None:
        for item in fields(self):
            value = getattr(self, item.name)
            low, high = item.metadata.get("low"), item.metadata.get("high")
            if low is not None and value is not None and not low <= value <= high:
                raise InputError(f"scene setting {item.name} is {value}; expected {low} to {high}.")
            if item.name.endswith("_rgb") and not all(0 <= c <= 255 for c in value):
                raise InputError(
                    f"scene setting {item.name} is {value}; expected red, green and blue, "
                    "each from 0 to 255."
                )
        if self.below and self.reflections:
            raise InputError(
                "a camera below the belt sees no mirror image of the animal: leave out "
                "reflections, or the belt of glass."
            )

    @property
    def width(self) -> int:
        """Width of the picture in px."""
        return round(FULL_WIDTH * self.scale)

    @property
    def height(self) -> int:
        """Height of the picture in px."""
        return round(FULL_HEIGHT * self.scale)


_PRESETS: dict[str, dict[str, Any]] = {
    "easy": {
        "period_sd": 0.03,
        "phase_jitter": 0.01,
        "placement_sd_mm": 0.8,
        "drift_mm": 4.0,
        "sway_mm": 1.5,
        "paw_rgb": (205.0, 148.0, 134.0),
        "belt_marks": 0.5,
        "read_noise": 0.8,
        "shot_noise": 2.0,
        "blur_px": 0.5,
    },
    "normal": {},
    "hard": {
        "period_sd": 0.08,
        "duty_sd": 0.025,
        "phase_jitter": 0.035,
        "placement_sd_mm": 2.5,
        "drift_mm": 15.0,
        "sway_mm": 6.0,
        "paw_rgb": (140.0, 112.0, 101.0),
        "tail_lift_deg": 20.0,
        "belt_marks": 2.0,
        "light": 0.75,
        "light_gradient": 0.35,
        "read_noise": 3.0,
        "shot_noise": 7.0,
        "blur_px": 1.1,
    },
}


def scene_settings(
    difficulty: str = "normal", *, changes: Mapping[str, Any] | None = None
) -> SceneSettings:
    """Return one of the presets, with some settings changed.

    Parameters
    ----------
    difficulty : {"easy", "normal", "hard"}
        The preset: how regular the gait, how clear the colours, how quiet the sensor.
    changes : mapping, optional
        Fields of :class:`SceneSettings` and their values.

    Returns
    -------
    SceneSettings
        The settings.

    Raises
    ------
    InputError
        For an unknown preset or setting, or a value that makes no sense.
    """
    if difficulty not in _PRESETS:
        raise InputError(
            f"difficulty is {difficulty!r}{did_you_mean(difficulty, _PRESETS)}; "
            f"expected {', '.join(_PRESETS)}."
        )
    values = {**_PRESETS[difficulty], **(changes or {})}
    return build_settings(SceneSettings, values, where="scene settings")
