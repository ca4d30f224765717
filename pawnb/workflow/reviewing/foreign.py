"""Other programs' tracks corrected over their videos, and written back as they were made."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from pawnb.errors import InputError
from pawnb.files import GuardedFile
from pawnb.io.formats import find_entry, read_any_tracks, recognise_format, write_any_tracks
from pawnb.schema import ORIGIN_CODE, Tracks, make_tracks
from pawnb.trial import Animal, Trial, View
from pawnb.workflow.conversion.film_of_tracks import doubt_film_of_tracks

CORRECTED = "corrected_"
"""What names of corrected files begin with; the rest is that of the file they came from."""

Videos = str | Path | Sequence[str | Path] | Mapping[str, str | Path]
"""One video, those of the views in their order, or view to video."""


@dataclass(frozen=True, eq=False)
class ForeignTracks:
    """Tracks of another program, ready for a review.

    Parameters
    ----------
    path : Path
        Their file; it is only read.
    program : str
        Its format, one of :data:`pawnb.io.formats.FORMATS`.
    original : xarray.Dataset
        What is in it.
    animal : str
        The individual that is reviewed.
    trial : Trial
        Videos and views, as a review takes them.
    tracks : xarray.Dataset
        The individual's points in the pictures.
    """

    path: Path
    program: str
    original: Tracks
    animal: str
    trial: Trial
    tracks: Tracks

    def corrected(self, tracks: Tracks) -> Tracks:
        """Put what was corrected into the original; everything else stays as it is, bit by bit.

        Parameters
        ----------
        tracks : xarray.Dataset
            :attr:`tracks` with corrections.

        Returns
        -------
        xarray.Dataset
            The original with them.
        """
        new = self.original.copy(deep=True)
        who = [str(name) for name in new["individual"].to_numpy()].index(self.animal)
        was = self.tracks["image_position"].to_numpy()[..., 0]
        now = tracks["image_position"].to_numpy()[..., 0]
        same = ((was == now) | (np.isnan(was) & np.isnan(now))).all(axis=2)  # (n, V, P)
        sure = tracks["image_confidence"].to_numpy()[..., 0]
        same &= self.tracks["image_confidence"].to_numpy()[..., 0] == sure
        row, view, point = np.nonzero(~same)
        whence = tracks["image_origin"].to_numpy()[row, view, point, 0]  # placed, or missing now
        if "image_position" in new:
            new["image_position"].to_numpy()[row, view, :, point, who] = now[row, view, :, point]
            new["image_confidence"].to_numpy()[row, view, point, who] = sure[row, view, point]
            new["image_origin"].to_numpy()[row, view, point, who] = whence
        else:
            new["position"].to_numpy()[row, :, point, who] = now[row, view, :, point]
            new["confidence"].to_numpy()[row, point, who] = sure[row, view, point]
            new["origin"].to_numpy()[row, point, who] = whence
        return new

    def doubts(self) -> list[str]:
        """Say where the file does not fit the videos, as ``pawnb check`` does of a trial.

        Returns
        -------
        list of str
            See :func:`~pawnb.workflow.conversion.film_of_tracks.doubt_film_of_tracks`.
        """
        as_made = replace(self.trial, kind="tracks", tracks_file=self.path.name)
        return doubt_film_of_tracks(as_made, self.tracks)

    def write(self, tracks: Tracks, out: GuardedFile) -> list[Path]:
        """Write corrected tracks in the format of the file they came from.

        Parameters
        ----------
        tracks : xarray.Dataset
            :attr:`tracks` with corrections.
        out : GuardedFile
            The file to write; never the one they came from.

        Returns
        -------
        list of Path
            What was written.

        Raises
        ------
        InputError
            If the file was changed meanwhile, or cannot be written.
        """
        with out.writing(refused="nothing was written, and every correction is in its file"):
            return write_any_tracks(self.corrected(tracks), out.path, program=self.program)


def corrected_file(path: Path) -> Path:
    """Return where a review writes the corrected tracks of a file: beside it."""
    return path.with_name(f"{CORRECTED}{path.name}")


def open_foreign(
    path: str | Path,
    videos: Videos,
    *,
    fps: float | None = None,
    program: str | None = None,
    animal: str | None = None,
) -> ForeignTracks:
    """Read tracks of another program for a review over their videos.

    Parameters
    ----------
    path : str or Path
        The file: DeepLabCut, SLEAP, DLTdv, movement and others that hold points in pictures.
    videos : str, Path, sequence or mapping
        The video of the view, or those of the views, in the order of the file or by name.
    fps : float, optional
        Frames per second, where the file does not say.
    program : str, optional
        Its format; default as it looks.
    animal : str, optional
        Which individual, where the file has several.

    Returns
    -------
    ForeignTracks
        What a review needs.

    Raises
    ------
    InputError
        If the file cannot be read or written back, holds no points in pictures, or has more or
        fewer views than there are videos.
    """
    path = Path(path)
    program = recognise_format(path) if program is None else program
    if find_entry(program).write is None:
        raise InputError(f"{path.name}: {find_entry(program).title} is read but not written back.")
    original = read_any_tracks(path, fps=fps, program=program)
    animals = [str(name) for name in original["individual"].to_numpy()]
    if animal is None and len(animals) > 1:
        raise InputError(f"{path.name} has {', '.join(animals)}; say which with animal=.")
    animal = animals[0] if animal is None else animal
    if animal not in animals:
        raise InputError(f"{path.name} has no animal {animal!r}; there are {', '.join(animals)}.")
    own = original.isel(individual=[animals.index(animal)])
    if "image_position" not in own and (
        own.sizes["space"] != 2 or own.attrs.get("units") not in (None, "px")
    ):
        raise InputError(
            f"{path.name}: points in space, none in pictures; there is nothing to see."
        )
    names = _views(own)
    files = _videos(videos, names, path)
    fps = float(own.attrs["fps"])
    views = tuple(View(name=name, video=str(file.resolve())) for name, file in files.items())
    trial = Trial(
        kind="paws", name=path.stem, fps=fps, animal=Animal(id=animal), views=views,
        folder=path.parent,
    )  # fmt: skip
    return ForeignTracks(path, program, original, animal, trial, _in_pictures(own, names, fps))


def _views(tracks: Tracks) -> list[str]:
    """Return the names of the views; one that the file does not name is ``view``."""
    return [str(n) for n in tracks["view"].to_numpy()] if "image_position" in tracks else ["view"]


def _videos(videos: Videos, names: Sequence[str], path: Path) -> dict[str, Path]:
    """Return the video of each view."""
    if isinstance(videos, Mapping):
        given = {str(name): Path(video) for name, video in videos.items()}
    else:
        listed = [videos] if isinstance(videos, str | Path) else list(videos)
        if len(listed) != len(names):
            raise InputError(
                f"{path.name} has {len(names)} view{'' if len(names) == 1 else 's'} "
                f"({', '.join(names)}), and {len(listed)} videos are named; name one for each."
            )
        given = dict(zip(names, map(Path, listed), strict=True))
    if set(given) != set(names):
        raise InputError(
            f"{path.name} has the views {', '.join(names)}, and videos are named for "
            f"{', '.join(given)}."
        )
    for video in given.values():
        if not video.exists():
            raise InputError(f"{video}: no such video.")
    return {name: given[name] for name in names}


def _in_pictures(own: Tracks, names: Sequence[str], fps: float) -> Tracks:
    """Return the points of one individual as positions in pictures."""
    points = [str(name) for name in own["keypoint"].to_numpy()]
    frames = own["frame"].to_numpy() if "frame" in own.coords else np.arange(own.sizes["time"])
    tracks = make_tracks(
        frames, points, fps=fps, views=list(names), space=("x", "y"), unit="px",
        time_s=own["time"].to_numpy(),
    )  # fmt: skip
    if "image_position" in own:
        uv = own["image_position"].to_numpy()
        confidence = own["image_confidence"].to_numpy()
    else:
        uv = own["position"].to_numpy()[:, None]
        confidence = own["confidence"].to_numpy()[:, None]
    there = np.isfinite(uv).all(axis=2)  # (n, V, P, 1)
    tracks["image_position"].to_numpy()[:] = uv
    tracks["image_confidence"].to_numpy()[:] = np.where(there, np.nan_to_num(confidence), 0.0)
    tracks["image_origin"].to_numpy()[:] = np.where(there, ORIGIN_CODE["measured"], 0)
    tracks["position"].to_numpy()[:] = uv[:, 0]
    tracks["confidence"].to_numpy()[:] = np.where(there[:, 0], np.nan_to_num(confidence[:, 0]), 0.0)
    tracks["origin"].to_numpy()[:] = np.where(there[:, 0], ORIGIN_CODE["measured"], 0)
    return tracks
