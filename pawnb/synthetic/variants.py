"""Named ways in which a synthetic recording of a mouse can differ from a good one."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

from pawnb.errors import InputError, did_you_mean

if TYPE_CHECKING:  # the command line lists variants, and is to start fast
    from pawnb.synthetic.scene import SceneSettings

    Change = Callable[[SceneSettings], SceneSettings]

LOW_RATE_EVERY = 5
_CRF = re.compile(r"h264-crf(\d{1,2})")
_EVERY = re.compile(r"low-rate-(\d{1,3})")


def _with(**values: object) -> Change:
    """Return a change that gives some settings fixed values."""
    return lambda scene: dataclasses.replace(scene, **values)  # type: ignore[arg-type]


def _low_rate(every: int) -> Change:
    """Return a change that keeps one frame of so many."""
    return lambda scene: dataclasses.replace(scene, fps=scene.fps / every)


_CHANGES: dict[str, tuple[str, Change]] = {
    "grey": ("a grey camera", _with(grey=True)),
    "low-rate": (
        f"every {LOW_RATE_EVERY}th frame only; low-rate-K: every K-th",
        _low_rate(LOW_RATE_EVERY),
    ),
    "motion-blur": ("the shutter is open for 0.8 of the time between frames", _with(shutter=0.8)),
    "covered-lift-off": (
        "fur covers a paw at lift-off, so that it turns dark",
        _with(covered_paws=0.9),
    ),
    "white-mouse": (
        "a white mouse with pink paws on a dark belt",
        _with(
            fur_rgb=(198.0, 195.0, 188.0),
            paw_rgb=(205.0, 148.0, 140.0),
            belt_rgb=(50.0, 53.0, 54.0),
        ),
    ),
    "glass-belt": (
        "two cameras below, which see all paws through a belt of glass",
        _with(below=True, n_views=2),
    ),
    "reflections": ("belt and walls shine: paws have mirror images", _with(reflections=0.3)),
    "flicker": ("lamps that flicker with the mains", _with(flicker=0.2)),
}

VARIANTS: dict[str, str] = {
    **{name: said for name, (said, _) in _CHANGES.items()},
    "h264-crfNN": "H.264 of quality NN: 0 is the best, 23 is usual, 51 the worst",
}
"""What can be asked for, and what it is."""


def vary(scene: SceneSettings, names: Iterable[str]) -> SceneSettings:
    """Return settings changed as some variants say.

    Parameters
    ----------
    scene : SceneSettings
        The settings.
    names : iterable of str
        Variants, in any order; see :data:`VARIANTS`. ``low-rate-K`` and ``h264-crfNN`` take any
        number.

    Returns
    -------
    SceneSettings
        The changed settings.

    Raises
    ------
    InputError
        For a variant that is unknown, given twice, or cannot be.
    """
    names = list(names)
    kinds = [re.sub(r"-?\d+$", "", name) for name in names]
    for kind in kinds:
        if kinds.count(kind) > 1:
            raise InputError(f"variants {', '.join(names)}: {kind} is there more than once.")
    for name in names:
        scene = _change(name)(scene)
    return scene


def _change(name: str) -> Change:
    """Return what a variant does."""
    if name in _CHANGES:
        return _CHANGES[name][1]
    if crf := _CRF.fullmatch(name):
        return _with(crf=int(crf[1]))
    every = _EVERY.fullmatch(name)
    if every and int(every[1]):
        return _low_rate(int(every[1]))
    raise InputError(
        f"variant {name!r} is unknown{did_you_mean(name, VARIANTS)}; known are "
        f"{', '.join(VARIANTS)}."
    )
