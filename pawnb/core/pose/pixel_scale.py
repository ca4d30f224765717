"""How many pixels one unit is: from two clicks, or from a grid of known spacing in the picture.

Pullar 2009, §2.2: a 1 cm grid on a transparency under the animal. It may be faint: its lines
are looked for all over the picture at once, in the picture's spectrum.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from scipy import fft

from pawnb.arrays import ByteArray, Float32Array, FloatArray, IntArray
from pawnb.core.pixels.grey import grey
from pawnb.errors import InputError
from pawnb.signals.robust import MAD_TO_SD

_MOST_REPEATS = 12
"""So many lines may be taken for one, at most."""
_SHORTEST_PX = 6.0
"""Lines nearer to each other than this are not distinguished from texture."""
_FEWEST_LINES = 4
"""Fewer lines in a direction tell no spacing."""
_PEAKS = 40
"""Peaks of the spectrum that are tried, the strongest first."""
_HARMONICS = 4
"""The strongest peaks of the spectrum are tried as the first to fourth multiple of a grid's."""
_HIGHEST = 0.34
"""Multiples above this frequency (per px) are left out: noise and compression rule there."""
_NOISE = 0.7
"""A multiple counts against a grid where its power is no more than e to this times that between."""
_SURE_SCORE = 4.0
"""Least evidence along each direction: noise and vignetting alone give at most about 2."""
_BIN_PX = 0.25
"""Width of the bins across the lines."""


@dataclass(frozen=True)
class PxPerUnit:
    """A scale and how well it is known.

    Parameters
    ----------
    px_per_unit : float
        px of the view per unit of length.
    sd : float
        Its standard error.
    spacing_px : float
        Distance of neighbouring lines, or of the two clicks, px.
    angle_deg : float
        Direction of the lines nearest to +u, or from the first click to the second, degrees
        from +u towards +v.
    n_lines : tuple of int
        Lines used in each direction; (0, 0) for clicks.
    """

    px_per_unit: float
    sd: float
    spacing_px: float
    angle_deg: float
    n_lines: tuple[int, int] = (0, 0)

    def text(self, unit: str = "unit") -> str:
        """Return the scale in words."""
        lines = f", from {sum(self.n_lines)} lines" if any(self.n_lines) else ""
        return f"{self.px_per_unit:.4g} ± {self.sd:.2g} px per {unit}{lines}"


def scale_from_clicks(
    first: tuple[float, float],
    second: tuple[float, float],
    *,
    distance: float,
    click_sd_px: float = 1.0,
) -> PxPerUnit:
    """Return px per unit from two points a known distance apart.

    Parameters
    ----------
    first, second : tuple of float
        u, v, px of the view.
    distance : float
        How far apart they are, in the unit.
    click_sd_px : float
        How exactly a person clicks, SD along each axis, px.

    Returns
    -------
    PxPerUnit
        The scale; its standard error is that of the clicks.

    Raises
    ------
    InputError
        If the distance is not positive, or the clicks are on the same place.
    """
    if not (np.isfinite(distance) and distance > 0):
        raise InputError(f"the distance between the clicks is {distance}; expected more than 0.")
    step = np.subtract(second, first).astype(float)
    length = float(np.hypot(*step))
    if not length > 3 * click_sd_px:
        raise InputError(
            f"the two clicks are {length:.1f} px apart; click two points far from each other."
        )
    return PxPerUnit(
        px_per_unit=length / distance,
        sd=float(np.sqrt(2) * click_sd_px / distance),
        spacing_px=length,
        angle_deg=float(np.degrees(np.arctan2(step[1], step[0]))),
    )


def scale_from_grid(picture: ByteArray, *, spacing: float) -> PxPerUnit:
    """Return px per unit from a square grid that is seen in the picture.

    The lines' directions and spacing are the peaks of the spectrum that repeat at their
    multiples in two perpendicular directions. Then each line's place is measured in the
    picture's mean along the lines, and the spacing is the slope of place against number.

    Parameters
    ----------
    picture : ndarray, shape (H, W) or (H, W, 3)
        A picture, best the mean of empty frames (:class:`Background.mean`).
    spacing : float
        Distance of neighbouring lines in the unit.

    Returns
    -------
    PxPerUnit
        The mean of both directions, and its standard error.

    Raises
    ------
    InputError
        If there is no grid that can be measured: too faint, fewer than 4 lines, lines nearer
        than 6 px, or two directions that differ by more than 5 % (a tilted camera).
    """
    if not (np.isfinite(spacing) and spacing > 0):
        raise InputError(f"the grid's spacing is {spacing}; expected more than 0.")
    flat = _flattened(grey(picture))
    found = _find_pitch(flat)
    if found is None:
        raise InputError(
            "no grid was found in the picture: nothing repeats evenly in two perpendicular "
            "directions. Show a sharp picture of the empty arena, or give two clicks instead."
        )
    pitch, angle = found
    angle = _refined_angle(flat, angle)
    across = _measure(flat, pitch, angle)
    down = _measure(flat, pitch, angle + 90.0)
    if across is None or down is None:
        raise InputError(
            f"a grid of about {pitch:.1f} px was seen, but fewer than {_FEWEST_LINES} of its lines "
            "could be measured in one direction: they are too faint, or the camera looks at them "
            "from the side; give two clicks instead."
        )
    if abs(np.log(across[0] / down[0])) > 0.05:
        raise InputError(
            f"the grid's lines are {across[0]:.2f} px apart in one direction and {down[0]:.2f} px "
            "in the other: the camera looks at it from the side. Straighten the view, or give "
            "two clicks along the animal's path."
        )
    weights = np.array([1 / across[1] ** 2, 1 / down[1] ** 2])
    mean = float(np.average([across[0], down[0]], weights=weights))
    # where the directions differ by more than their errors, that difference is the error
    error = max(float(weights.sum() ** -0.5), abs(across[0] - down[0]) / 2)
    # lines across the direction `angle` run at a right angle to it
    lie = min(((angle + k * 90.0 + 180) % 360 - 180 for k in range(4)), key=abs)
    return PxPerUnit(mean / spacing, error / spacing, mean, float(lie), (across[2], down[2]))


def _flattened(picture: Float32Array) -> Float32Array:
    """Return the picture without slow changes of light, as even in contrast as it can be.

    Contrast is measured about each place: the edge of the arena is far stronger than the grid.
    """
    size = max(picture.shape) / 40
    flat = picture - cv2.GaussianBlur(cv2.medianBlur(picture, 5), (0, 0), size)
    spread = np.sqrt(cv2.GaussianBlur(flat**2, (0, 0), size)) + 0.05
    return np.asarray(np.clip(flat / spread, -3, 3), dtype=np.float32)


def _find_pitch(flat: Float32Array) -> tuple[float, float] | None:
    """Return distance (px) and direction (degrees) from line to line, or None without a grid."""
    height, width = flat.shape
    window = np.outer(np.hanning(height), np.hanning(width)).astype(np.float32)
    power = np.abs(fft.fftshift(fft.fft2(flat * window))) ** 2
    log = np.log(power + 1e-9)
    # against its surroundings, which fall off with frequency
    log -= cv2.medianBlur(cv2.blur(log.astype(np.float32), (9, 9)), 5) + 0.577
    middle = np.array([height // 2, width // 2])
    cycles = np.array([height, width])
    v, u = np.mgrid[:height, :width]
    away = np.hypot((v - middle[0]) / height, (u - middle[1]) / width)
    lowest = 2.0 / min(height, width)
    log[(away < lowest) | (away > 0.48)] = 0.0
    top = log == cv2.dilate(log, np.ones((5, 5)))
    places = np.argwhere(top & (u >= middle[1]))
    places = places[np.argsort(log[places[:, 0], places[:, 1]])[::-1][:_PEAKS]]
    best: tuple[float, float, float] | None = None
    for place in places:
        peak = (_summit(log, place) - middle) / cycles
        for multiple in range(1, _HARMONICS + 1):
            pitch = multiple / float(np.hypot(*peak))
            if not _SHORTEST_PX <= pitch <= min(height, width) / (_FEWEST_LINES - 1):
                continue
            one, refined = _evidence(log, peak / multiple)
            two, _ = _evidence(log, np.array([-refined[1], refined[0]]))
            if min(one, two) > _SURE_SCORE and (best is None or one + two > best[0]):
                angle = float(np.degrees(np.arctan2(refined[0], refined[1])))
                best = (one + two, 1 / float(np.hypot(*refined)), angle)
    return None if best is None else (best[1] / _repeats(log, best[1], best[2]), best[2])


def _repeats(log: Float32Array, pitch: float, angle_deg: float) -> int:
    """Return how many lines there really are in what was taken for one period.

    If only every second (third, ...) multiple of the frequency stands out, there are two (three).
    Lines a few pixels apart have multiples beyond what pixels can show, which come back as others:
    a grid 7.3 px wide repeats itself in whole pixels every 73.
    """
    turn = np.radians(angle_deg)
    along = np.array([np.sin(turn), np.cos(turn)]) / pitch
    heights = []
    for step in (along, np.array([-along[1], along[0]])):
        top = min(24, int(_HIGHEST / np.hypot(*step)))
        heights.append([_height(log, k * step) - _between(log, k * step, step) for k in
                        range(1, top + 1)])  # fmt: skip
    for many in range(2, _MOST_REPEATS + 1):
        others = [h for row in heights for k, h in enumerate(row, 1) if k % many]
        every = [h for row in heights for k, h in enumerate(row, 1) if not k % many]
        if every and np.mean(others) < 0.25 * np.mean(every):
            return many * _repeats(log, pitch / many, angle_deg)
    return 1


def _evidence(log: Float32Array, frequency: FloatArray) -> tuple[float, FloatArray]:
    """Return how strongly multiples of a frequency (v, u; per px) stand out, and it, refined."""
    cycles = np.array(log.shape)
    middle = cycles // 2
    total, best = 0.0, frequency
    for k in range(1, int(_HIGHEST / np.hypot(*frequency)) + 1):
        place = np.round(middle + k * best * cycles).astype(int)
        if not ((place > 1) & (place < cycles - 2)).all():
            break
        near = log[place[0] - 1 : place[0] + 2, place[1] - 1 : place[1] + 2]
        # a single edge has all frequencies of its direction, a grid none between multiples
        excess = float(near.max()) - _between(log, k * best, best)
        total += float(np.clip(excess - _NOISE, -_NOISE, 3.0))
        if excess > 1.5:
            summit = place + np.array(np.unravel_index(np.argmax(near), near.shape)) - 1
            best = (_summit(log, summit) - middle) / cycles / k
    return total, best


def _between(log: Float32Array, at: FloatArray, step: FloatArray) -> float:
    """Return the mean height of the spectrum half a step before and after a frequency."""
    return (_height(log, at - 0.5 * step) + _height(log, at + 0.5 * step)) / 2


def _height(log: Float32Array, frequency: FloatArray) -> float:
    """Return the height of the spectrum at a frequency (v, u; per px) or beside it."""
    cycles = np.array(log.shape)
    v, u = np.clip(np.round(cycles // 2 + frequency * cycles).astype(int), 1, cycles - 2)
    return float(log[v - 1 : v + 2, u - 1 : u + 2].max())


def _summit(log: Float32Array, place: IntArray) -> FloatArray:
    """Return the place of a peak between pixels: the top of a parabola along each axis."""
    out = place.astype(float)
    for axis in (0, 1):
        step = np.eye(2, dtype=int)[axis]
        if not (0 < place[axis] < log.shape[axis] - 1):
            continue
        low, here, high = (log[tuple(place + k * step)] for k in (-1, 0, 1))
        bend = low - 2 * here + high
        if bend < 0:
            out[axis] += float(np.clip(0.5 * (low - high) / bend, -0.5, 0.5))
    return out


def _profile(flat: Float32Array, angle_deg: float) -> tuple[np.ndarray, np.ndarray]:
    """Return places along a direction (px) and the mean of the picture across it."""
    height, width = flat.shape
    turn = np.radians(angle_deg)
    along = (np.arange(width) * np.cos(turn))[None] + (np.arange(height) * np.sin(turn))[:, None]
    first = float(along.min())
    bins = ((along - first) / _BIN_PX).astype(np.intp).ravel()
    count = np.bincount(bins)
    total = np.bincount(bins, weights=flat.ravel())
    used = count > 0.2 * np.median(count[count > 0])
    places = first + (np.arange(len(count)) + 0.5) * _BIN_PX
    return places[used], total[used] / count[used]


def _refined_angle(flat: Float32Array, angle_deg: float) -> float:
    """Return the direction in which the profile is sharpest, near the one given."""
    for step in (0.2, 0.05, 0.0125):
        tries = angle_deg + step * np.arange(-3, 4)
        strengths = []
        for angle in tries:
            profiles = [_profile(flat, float(angle) + more) for more in (0.0, 90.0)]
            strengths.append(sum(float(np.var(values)) for _, values in profiles))
        angle_deg = float(tries[int(np.argmax(strengths))])
    return angle_deg


def _measure(flat: Float32Array, pitch: float, angle_deg: float) -> tuple[float, float, int] | None:
    """Return spacing, its standard error (px) and the number of lines along a direction."""
    places, values = _profile(flat, angle_deg)
    values = values - np.median(values)
    tries = pitch * (1 + 0.01 * np.linspace(-1, 1, 41))
    folds = [_folded(places, values, float(p)) for p in tries]
    best = int(np.argmax([np.abs(fold).max() for fold in folds]))
    pitch, fold = float(tries[best]), folds[best]
    sign = 1.0 if fold.max() > -fold.min() else -1.0
    origin = (int(np.argmax(sign * fold)) + 0.5) / len(fold) * pitch
    first, last = np.ceil((places[0] - origin) / pitch), (places[-1] - origin) / pitch
    numbers, lines = [], []
    for n in np.arange(first, np.floor(last) + 1):
        near = np.abs(places - origin - n * pitch) < 0.25 * pitch
        if not near.any() or np.ptp(places[near]) < 0.4 * pitch:
            continue  # a line at the edge of the picture
        lifted = sign * values[near]
        if lifted.max() < 0.4 * np.abs(fold).max():
            continue  # where the arena is dark, or something lies on the line
        lifted = np.maximum(lifted - 0.5 * lifted.max(), 0.0)
        numbers.append(n)
        lines.append(float(np.average(places[near], weights=lifted)))
    return _slope(np.array(numbers), np.array(lines), pitch)


def _folded(places: FloatArray, values: FloatArray, pitch: float) -> FloatArray:
    """Return the shape of one period: the median of all, so that walls and dirt do not count."""
    n = max(8, int(pitch / (2 * _BIN_PX)))
    bins = ((places % pitch) / pitch * n).astype(int) % n
    order = np.argsort(bins, kind="stable")
    parts = np.split(values[order], np.searchsorted(bins[order], np.arange(1, n)))
    fold = np.array([np.median(part) if len(part) else 0.0 for part in parts])
    return np.asarray(fold - np.median(fold))


def _slope(numbers: FloatArray, lines: FloatArray, pitch: float) -> tuple[float, float, int] | None:
    """Return slope of place against number, its standard error, and how many lines it used."""
    for _ in range(4):
        if len(numbers) < _FEWEST_LINES:
            return None
        away = numbers - numbers.mean()
        slope = float(away @ lines / (away @ away))
        off = lines - lines.mean() - slope * away
        spread = max(MAD_TO_SD * float(np.median(np.abs(off))), 0.1)
        good = np.abs(off) < 4 * spread
        if good.all():
            break
        numbers, lines = numbers[good], lines[good]
    variance = float(off @ off) / max(len(off) - 2, 1)
    if variance > (0.12 * pitch) ** 2:
        return None
    # a tenth of a bin is what the profile cannot tell
    error = np.sqrt((variance + (0.1 * _BIN_PX) ** 2) / float(away @ away))
    return slope, float(error), len(numbers)
