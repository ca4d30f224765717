r"""Evidence of correlation: patches about the clicks, turned a little, found again.

Pictures are in the body's frame, so that patches turn and scale with the body; a few further
turns are tried for the limb. A score, the normalised cross-correlation after Fisher's
transformation, is compared with scores elsewhere in the same picture (mean 0, variance 1 there).
Where flow from clicks is trusted the place is known: the scores there say how high those of the
point itself are. A peak with the score s is the point, not chance or another peak, with

.. math:: \pi = \frac{r(s)}{M + \sum_i r(s_i)}, \qquad r(s) = \frac{N(s; m, v)}{N(s; 0, 1)}

of M places and turns that differ and peaks i. The ratio of likelihoods there is
:math:`1 + \pi (G - 1)`: however clear, one that matches may be another leg of the same look.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np

from pawnb.arrays import ByteArray, Float32Array, FloatArray
from pawnb.core.parallel import in_parts
from pawnb.core.paws.offline.annotations import Annotations
from pawnb.core.paws.offline.detection.evidence import Detections
from pawnb.core.paws.offline.detection.parameters import LEARNT
from pawnb.core.paws.offline.parameters import CorrelationParameters
from pawnb.core.paws.offline.scene.stack import BodyStack

_TINY_NORM, _FLAT, _EVEN_SCORES, _MOST_LOG = 1e-6, 1e-2, 1e-3, 50.0
"""Guard: least norm of a patch, variance of grey values and standard deviation of scores, as what
is flat correlates with nothing; largest exponent."""
_KEPT_SPECTRA = 16
"""Resource: clicks of whose patches the Fourier transforms are kept, about 1 MB each; frames go by
in order, so that each thread needs those of one or two."""


@dataclass(frozen=True)
class _Scores:
    """Standardised scores (h, w) of a window; its first px in small pictures, its middle."""

    values: Float32Array
    corner: FloatArray
    places: float
    """How many of its places and turns differ."""


def detect_by_correlation(
    stack: BodyStack,
    annotations: Annotations,
    parameters: CorrelationParameters,
    *,
    radius_px: float,
    followed: Detections,
) -> Detections:
    """Find patches about the clicks again.

    Parameters
    ----------
    stack : BodyStack
        The view.
    annotations : Annotations
        The clicks.
    parameters : CorrelationParameters
        The kind's parameters.
    radius_px : float
        About half a paw, working px.
    followed : Detections
        Places to which flow leads from clicks (:func:`.motion.detect_by_motion`): where their
        log-odds are high, they say how high scores of the points themselves are.

    Returns
    -------
    Detections
        At most ``peaks`` for each point and row.
    """
    placed = annotations.moved(stack.to_body)
    half = max(2, round(parameters.patch_radii * radius_px / LEARNT.patch_shrink))
    known = _known_places(stack, followed, parameters)
    small = [
        cv2.resize(
            g,
            None,
            fx=1 / LEARNT.patch_shrink,
            fy=1 / LEARNT.patch_shrink,
            interpolation=cv2.INTER_AREA,
        )
        for g in stack.grey
    ]
    found = []
    for point in annotations.points:
        rows = annotations.rows_of(point)
        xy = {
            row: (np.asarray(placed.places[row][point]) + 0.5) / LEARNT.patch_shrink - 0.5
            for row in rows
        }
        patches = {row: _patches(small[row], xy[row], half, parameters) for row in rows}
        reach = parameters.reach * stack.extent_px * stack.scale / LEARNT.patch_shrink
        low = np.min(list(xy.values()), axis=0) - reach
        high = np.max(list(xy.values()), axis=0) + reach
        found.append(_find_point(small, point, patches, (low, high), known, half, parameters))
    table = np.concatenate(found) if found else np.empty((0, 5))
    row = table[:, 0].astype(int)
    place = stack.to_grid((table[:, 2:4] + 0.5) * LEARNT.patch_shrink - 0.5)
    return Detections(
        row=row,
        point=table[:, 1].astype(int),
        uv=stack.picture_of(place, row),
        log_odds=table[:, 4],
        sd_px=np.full(len(table), parameters.sd * stack.spacing / stack.scale),
    )


def _known_places(
    stack: BodyStack, followed: Detections, parameters: CorrelationParameters
) -> dict[tuple[int, int], np.ndarray]:
    """Return (row, point) to where flow surely leads, px of small pictures."""
    best = followed.log_odds.max(initial=-np.inf)
    sure = np.flatnonzero(followed.log_odds > best + np.log(parameters.sure))
    places = {}
    for i in sure:
        row = int(followed.row[i])
        A = stack.to_body[row]
        xy = A[:, :2] @ followed.uv[i] + A[:, 2]
        places[row, int(followed.point[i])] = (xy + 0.5) / LEARNT.patch_shrink - 0.5
    return places


def _patches(
    picture: np.ndarray, xy: np.ndarray, half: int, parameters: CorrelationParameters
) -> list[np.ndarray]:
    """Return the patch about a place, turned by some angles."""
    side = 2 * half + 1
    patches = []
    for degrees in parameters.turns_deg:
        turn = cv2.getRotationMatrix2D((float(xy[0]), float(xy[1])), degrees, 1.0)
        turn[:, 2] += half - xy
        patches.append(cv2.warpAffine(picture, turn, (side, side), borderMode=cv2.BORDER_REPLICATE))
    return patches


def _find_point(
    small: Sequence[ByteArray],
    point: int,
    patches: Mapping[int, Sequence[np.ndarray]],
    window: tuple[FloatArray, FloatArray],
    known: Mapping[tuple[int, int], np.ndarray],
    half: int,
    parameters: CorrelationParameters,
) -> FloatArray:
    """Return row, point, x, y (px of small pictures) and log-odds of peaks, (m, 5)."""
    clicked = np.array(sorted(patches))
    wanted = [t for t in range(len(small)) if t not in patches]
    height, width = small[0].shape
    x0, y0 = np.maximum(np.floor(window[0]).astype(int) - half, 0)
    x1, y1 = np.minimum(np.ceil(window[1]).astype(int) + half + 1, (width, height))
    if min(y1 - y0, x1 - x0) < 4 * half:
        return np.empty((0, 5))
    corner = np.array([x0 + half, y0 + half], float)

    @lru_cache(maxsize=_KEPT_SPECTRA)
    def spectra(row: int) -> list[Float32Array]:
        return _spectra(patches[row], (y1 - y0, x1 - x0))

    def look(t: int) -> tuple[list[tuple[float, float, float]], float, float]:
        nearest = int(clicked[np.abs(clicked - t).argmin()])
        scores = _score(small[t][y0:y1, x0:x1], spectra(nearest), corner, half)
        if scores is None:
            return [], np.nan, np.nan
        at = known.get((t, point))
        score = np.nan if at is None else _read(scores, at)
        return _peaks(scores, half, parameters.peaks), score, scores.places

    seen = in_parts(look, wanted)
    mean, sd = scores_of_point(np.array([score for _, score, _ in seen]))
    rows = []
    for t, (peaks, _, places) in zip(wanted, seen, strict=True):
        s = np.array([peak[2] for peak in peaks])
        # a score higher than the point's own mean is no worse than the mean
        log = -(np.maximum(mean - s, 0.0) ** 2) / (2 * sd**2) - np.log(sd) + s**2 / 2
        ratio = np.exp(np.minimum(log, _MOST_LOG))
        share = ratio / (places + ratio.sum())
        for (x, y, _), own in zip(peaks, share, strict=True):
            if own > LEARNT.least_peak:
                rows.append((t, point, x, y, np.log((parameters.gain - 1) * own)))
    return np.array(rows, float).reshape(-1, 5)


def scores_of_point(seen: FloatArray) -> tuple[float, float]:
    """Return mean and standard deviation of scores where the point is, from those seen (m,).

    NaN where none is known; what is taken to be known beforehand counts as ten of them.
    """
    own = seen[np.isfinite(seen)]
    weight = LEARNT.score_worth + len(own)
    mean = (LEARNT.score_worth * LEARNT.score_mean + own.sum()) / weight
    square = (
        LEARNT.score_worth * (LEARNT.score_sd**2 + (LEARNT.score_mean - mean) ** 2)
        + ((own - mean) ** 2).sum()
    )
    return float(mean), float(np.sqrt(square / weight))


def _score(
    part: ByteArray, spectra: Sequence[Float32Array], corner: FloatArray, half: int
) -> _Scores | None:
    """Return standardised scores within a window, the best of the patches; None if all are high."""
    z = np.arctanh(
        np.clip(
            _best_correlation(part, spectra, 2 * half + 1),
            -LEARNT.highest_correlation,
            LEARNT.highest_correlation,
        )
    )
    y, x = np.unravel_index(z.argmax(), z.shape)
    elsewhere = np.ones(z.shape, bool)
    elsewhere[max(0, y - half) : y + half + 1, max(0, x - half) : x + half + 1] = False
    others = z[elsewhere]
    if not len(others):
        return None
    z = (z - others.mean()) / max(float(others.std()), _EVEN_SCORES)
    return _Scores(z, corner, len(spectra) * z.size / half**2)


def _spectra(patches: Sequence[ByteArray], shape: tuple[int, int]) -> list[Float32Array]:
    """Return the Fourier transforms of patches, without mean and of norm 1, for a window."""
    size = [cv2.getOptimalDFTSize(length) for length in shape]
    found = []
    for patch in patches:
        own = patch.astype(np.float32)
        own -= own.mean()
        # the patch has no mean, and what is alike has no variance
        own /= np.linalg.norm(own) + _TINY_NORM
        found.append(_transformed(own, size))
    return found


def _best_correlation(part: ByteArray, spectra: Sequence[Float32Array], side: int) -> Float32Array:
    """Return the highest correlation coefficient of patches of one size at every place.

    That of ``cv2.TM_CCOEFF_NORMED``; what does not depend on the patch is worked out once, the
    Fourier transform of the picture too.
    """
    height, width = (length - side + 1 for length in part.shape)
    grey = part.astype(np.float32)
    grey -= grey.mean()
    middle = (slice(side // 2, side // 2 + height), slice(side // 2, side // 2 + width))
    mean = cv2.boxFilter(grey, -1, (side, side))[middle]
    variance = cv2.sqrBoxFilter(grey, -1, (side, side))[middle] - mean * mean
    picture = _transformed(grey, spectra[0].shape)
    best = None
    for own in spectra:
        both = cv2.mulSpectrums(picture, own, 0, conjB=True)
        # what goes round the edge lies beyond the places at which a whole patch has room
        product = cv2.idft(both, flags=cv2.DFT_SCALE)[:height, :width]
        best = product if best is None else np.maximum(best, product)
    # squares were summed in float64, as what is left of them is small; the rest need not be
    norm = np.maximum(variance, _FLAT).astype(np.float32) * np.float32(side**2)
    return np.asarray(best / np.sqrt(norm, out=norm))


def _transformed(picture: np.ndarray, size: Sequence[int]) -> Float32Array:
    """Return the Fourier transform of a picture with 0 about it up to a size."""
    whole = np.zeros(size, np.float32)
    whole[: picture.shape[0], : picture.shape[1]] = picture
    # told how many rows are 0 OpenCV leaves its fast way, which takes a third of the time
    return np.asarray(cv2.dft(whole), np.float32)


def _peaks(scores: _Scores, half: int, count: int) -> list[tuple[float, float, float]]:
    """Return x, y and score of the highest peaks, ``half`` apart."""
    left, found = scores.values.copy(), []
    for _ in range(count):
        y, x = np.unravel_index(left.argmax(), left.shape)
        if not np.isfinite(left[y, x]):
            break
        found.append((x + scores.corner[0], y + scores.corner[1], float(left[y, x])))
        left[max(0, y - half) : y + half + 1, max(0, x - half) : x + half + 1] = -np.inf
    return found


def _read(scores: _Scores, at: FloatArray) -> float:
    """Return the highest score of 3 x 3 px about a place, NaN outside the window."""
    x, y = np.rint(at - scores.corner).astype(int)
    part = scores.values[max(0, y - 1) : max(0, y + 2), max(0, x - 1) : max(0, x + 2)]
    return float(part.max()) if part.size else np.nan
