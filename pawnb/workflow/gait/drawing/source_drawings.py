"""Figures of the tracks themselves: paths in space, joint ranges, the stride template's fit."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np
import pandas as pd

from pawnb import figures
from pawnb.core.paws.maghsoudi2019.settings import Maghsoudi2019Settings
from pawnb.core.paws.maghsoudi2019.template import KindTemplate, load_template
from pawnb.core.paws.maghsoudi2019.template_fit import fit_template
from pawnb.core.paws.offline.quality.assessment import Quality
from pawnb.errors import InputError
from pawnb.files import safe_name
from pawnb.io.native import points3d_table
from pawnb.kinematics import swing_direction
from pawnb.schema import ORIGIN_CODE, Tracks
from pawnb.signals import find_runs
from pawnb.workflow.gait.drawing.drawings import Drawing, make_drawing
from pawnb.workflow.reviewing.quality import verdict_on

_FEWEST_STRIDES = 1.0
_SHOWN_STRIDES = 2.0


@dataclass(frozen=True, kw_only=True, eq=False)
class SourceTracks:
    """Tracks of one input of the gait analysis, with what its tables call it.

    Parameters
    ----------
    tracks : xarray.Dataset
        The tracks.
    animal : str or None
        The animal; None where the tracks name several.
    trial : str
        The trial.
    legs : mapping
        Names of legs to names of points.
    """

    tracks: Tracks
    animal: str | None
    trial: str
    legs: dict[str, str]

    @cached_property
    def quality(self) -> Quality | None:
        """The verdict on them, where pawnb made them."""
        return verdict_on(self.tracks)


def source_drawings(
    sources: Sequence[SourceTracks], *, angles: pd.DataFrame | None = None
) -> Iterator[Drawing]:
    """List the figures that need tracks and not only the tables of an analysis.

    Parameters
    ----------
    sources : sequence of SourceTracks
        The tracks that were analysed.
    angles : pandas.DataFrame, optional
        Joint angles of jointed animals, of all inputs.

    Yields
    ------
    Drawing
        Of each trial: the paths of the feet in space, where they were tracked there, and the
        stride template fitted to a paw, where paws were tracked in pictures. Of all trials:
        the ranges of the joints, where there are any.
    """
    for source in sources:
        name = safe_name(f"{source.animal or 'all'}_{source.trial}")
        tracks = source.tracks
        if tracks.sizes["space"] == 3 and np.isfinite(tracks["position"]).any():
            for individual in tracks["individual"].to_numpy():
                own = tracks.sel(individual=[individual])
                who = name if source.animal is not None else safe_name(f"{individual}_{name}")
                yield make_drawing(
                    f"paths_3d_{who}", "paths_3d", partial(_paths, own, source.legs),
                    unit=str(tracks.attrs.get("units", "units")),
                )  # fmt: skip
        if "image_position" in tracks and _paws(source.legs):
            yield make_drawing(
                f"template_fit_{name}", "template_fit", partial(_template_fit, source)
            )
    if angles is not None and len(angles):
        yield make_drawing(
            "joint_ranges", "joint_ranges", partial(figures.build_joint_ranges_table, angles)
        )


def _paths(tracks: Tracks, legs: dict[str, str]) -> pd.DataFrame:
    """Return the paths of the feet in space, under the names of their legs."""
    table = points3d_table(tracks)
    names = {point: leg for leg, point in legs.items()}
    own = table[table["point"].isin(names)]
    return figures.build_paths_3d_table(own.assign(point=own["point"].map(names)))


def _paws(legs: dict[str, str]) -> dict[str, str]:
    """Return the legs that have a stride template, and whether it is that of front or hind."""
    kinds = {leg: Maghsoudi2019Settings().kind(leg) for leg in legs}
    return {leg: kind for leg, kind in kinds.items() if kind != "other"}


@dataclass(frozen=True, kw_only=True, eq=False)
class _Stretch:
    """A paw in a view, and the frames it was hidden in (``start`` is ``stop`` where never)."""

    view: str
    leg: str
    uv: np.ndarray
    start: int
    stop: int


def _template_fit(source: SourceTracks) -> pd.DataFrame:
    """Fit the template to the stride before the longest hidden stretch of any paw.

    Where no paw was hidden after a whole stride, to the last stride of the one that was seen
    most. A stretch is hidden where the tracker predicted the paw or found it by the template.
    """
    tracks = source.tracks
    fps = float(tracks.attrs["fps"])
    templates = load_template().kinds
    kinds = _paws(source.legs)
    stretches = [
        stretch
        for view in tracks["view"].to_numpy().tolist()
        for leg, kind in kinds.items()
        for stretch in _stretches(source, view, leg, templates[kind].period_s * fps)
    ]
    if not stretches:
        raise InputError(
            "template fit: no paw was tracked for a whole stride in a view without a break."
        )
    best = max(stretches, key=lambda one: (one.stop - one.start, one.start))
    return _fit_table(source, best, templates[kinds[best.leg]])


def _stretches(source: SourceTracks, view: str, leg: str, period: float) -> Iterator[_Stretch]:
    """Yield the hidden stretches of a paw that follow a whole stride in which it was seen."""
    own = source.tracks.sel(view=view, keypoint=source.legs[leg]).isel(individual=0)
    uv = own["image_position"].transpose("time", "image_space").to_numpy().astype(float)
    origin = own["image_origin"].to_numpy()
    seen = np.isin(origin, [ORIGIN_CODE["measured"], ORIGIN_CODE["edited"]])
    seen &= np.isfinite(uv).all(axis=1)
    hidden = np.isin(origin, [ORIGIN_CODE["predicted"], ORIGIN_CODE["resolved"]])
    needed = int(np.ceil(_FEWEST_STRIDES * period))
    for start, stop in find_runs(seen):
        if stop - start < needed:
            continue
        runs = find_runs(hidden[stop:])
        follows = len(runs) > 0 and runs[0][0] == 0
        end = stop + int(runs[0][1]) if follows else stop
        # beyond half a stride the template foretells nothing that could be judged
        yield _Stretch(
            view=view, leg=leg, uv=np.where(seen[:, None], uv, np.nan), start=stop,
            stop=min(end, stop + int(0.5 * period)),
        )  # fmt: skip


def _fit_table(source: SourceTracks, stretch: _Stretch, template: KindTemplate) -> pd.DataFrame:
    """Fit the template before the stretch, and put fit and tracked paw side by side."""
    fps = float(source.tracks.attrs["fps"])
    period = template.period_s * fps
    first = max(0, stretch.start - int(_SHOWN_STRIDES * period))
    last = min(len(stretch.uv), stretch.stop + int(0.5 * period))
    before = stretch.uv[first : stretch.start]
    facing = 1 if swing_direction(before[:, :, None], fs_hz=fps)[0] >= 0.0 else -1
    fit = fit_template(template, before, facing=facing, fps=fps)
    if fit is None:
        raise InputError(f"template fit: {stretch.leg} hardly moved in view {stretch.view}.")
    at = np.arange(first, last)
    used = max(first, stretch.start - round(period))
    uv_fit = np.where((at >= used)[:, None], fit.predict(at - first), np.nan)
    frames = source.tracks["frame"].to_numpy()[first:last]
    tracked = source.tracks.sel(view=stretch.view, keypoint=source.legs[stretch.leg])
    uv = tracked["image_position"].isel(individual=0).transpose("time", "image_space")
    number = dict(zip(at.tolist(), frames.tolist(), strict=True))
    end = number[stretch.start - 1] + 1
    foretold = (end, end + stretch.stop - stretch.start) if stretch.stop > stretch.start else None
    table = figures.build_template_fit_table(
        frames, uv.to_numpy()[first:last], uv_fit, used=(number[used], end), foretold=foretold
    )
    return table.assign(view=stretch.view, leg=stretch.leg, rms_px=fit.rms_px)
