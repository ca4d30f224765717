"""A page that shows tracks over their pictures without Python, to be sent to a co-author."""

from __future__ import annotations

import base64
import html
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pawnb.errors import InputError
from pawnb.files import write_whole
from pawnb.schema import Tracks
from pawnb.schema.arguments import checked_arguments
from pawnb.trial import Trial
from pawnb.widgets.surroundings import read_static

MOST_PAGE_FRAMES = 50
"""Frames that a page has where none are chosen."""

_DARK_STYLE = (
    "--jp-border-color1: #616161; --jp-ui-font-color1: #eee; --jp-layout-color1: #111; "
    "--jp-layout-color2: #333;"
)
_PAGE_STYLE = f"""
body {{ margin: 1em; font: 14px/1.4 system-ui, sans-serif; color: #212121; background: #fff; }}
body {{ overflow-wrap: anywhere; }}
h1 {{ font-size: 1.2em; }}
@media (prefers-color-scheme: dark) {{ body {{ color: #eee; background: #111; {_DARK_STYLE} }} }}
"""


class Paged:
    """A canvas that can be written as a page: the part of FrameCanvas that does it."""

    # of the canvas; traitlets wants no stricter words here
    span: Any
    stages: Any
    label: Any
    _esm: Any
    _css: Any
    _edit_lock: Any

    def overlay(self, frame: int) -> dict[str, Any]:
        """Return what is drawn over a frame."""
        raise NotImplementedError

    def _encode(
        self, frame: int, shrink: Sequence[int], *, quality: int | None = None
    ) -> list[bytes]:
        """Return one JPEG a view."""
        raise NotImplementedError

    def export_page(
        self,
        path: str | Path,
        *,
        frames: Sequence[int] | None = None,
        width: int = 1024,
        quality: int = 80,
        title: str = "",
    ) -> Path:
        """Write what is shown as one HTML file that needs no Python, for a co-author.

        Parameters
        ----------
        path : str or Path
            The page, ``.html``; written whole or not at all.
        frames : sequence of int, optional
            Which frames, for instance ``range(100, 160)``; default all, or 50 evenly spaced ones.
        width : int
            Most width of a view's picture, px.
        quality : int
            Of its JPEG, 1 to 100.
        title : str
            Heading of the page; default what the widget is called.

        Returns
        -------
        Path
            The page; nothing in it is fetched from elsewhere.

        Raises
        ------
        InputError
            If a frame cannot be shown, or the page cannot be written.
        """
        path = Path(path)
        if path.suffix.lower() not in (".html", ".htm"):
            raise InputError(f"{path.name}: a page is written as .html; give it that ending.")
        first, last = self.span
        chosen = _evenly(first, last) if frames is None else sorted({int(f) for f in frames})
        if not chosen or not first <= chosen[0] <= chosen[-1] <= last:
            raise InputError(f"frames are {chosen}; expected some of {first} to {last}.")
        # frames that follow one another keep their numbers, others are counted from 0
        follow = chosen == list(range(chosen[0], chosen[-1] + 1))
        begin = chosen[0] if follow else 0
        shown = [self._page_frame(frame, width=width, quality=quality) for frame in chosen]
        for frame, one in zip(chosen, shown, strict=True) if not follow else ():
            said = one["overlay"].get("caption")
            one["overlay"]["caption"] = f"frame {frame} of the recording{f', {said}' * bool(said)}"
        data = {
            "traits": self._page_traits()
            | {"span": [begin, begin + len(chosen) - 1], "frame": begin},
            "frames": shown,
            "lanes": self._page_lanes(chosen, begin),
        }
        script = (str(self._esm), str(self._css))
        page = _html(title or self.label, data, notes=self._page_notes(), script=script)
        return write_whole(path, page.encode("utf-8"))

    def _page_traits(self) -> dict[str, Any]:
        """Return what the browser is told on a page that only shows."""
        same = ("stages", "status", "label", "max_height", "selected", "cameras", "keys_help")
        told = {name: getattr(self, name) for name in same}
        return told | {
            "alarm": "", "actions": [], "sliders": [], "transport": "base64",
            "tell_selected": False, "lanes": [], "lanes_do": [], "stretch": [],
        }  # fmt: skip

    def _page_frame(self, frame: int, *, width: int, quality: int) -> dict[str, Any]:
        """Return pictures (as text) and overlay of a frame for a page."""
        shrink = [-(-stage["width"] // width) for stage in self.stages]
        pictures = self._encode(frame, shrink, quality=quality)
        with self._edit_lock:
            overlay = self.overlay(frame)
        return {"pictures": [as_text(data) for data in pictures], "overlay": overlay}

    def _page_lanes(self, frames: Sequence[int], first: int) -> dict[str, Any]:  # noqa: ARG002
        """Return the timeline of a page: a canvas has none."""
        return {}

    def _page_notes(self) -> list[str]:
        """Return what was corrected, in words: a canvas only shows."""
        return []


def as_text(data: bytes) -> str:
    """Return bytes in base64."""
    return base64.b64encode(data).decode("ascii")


def _html(
    title: str, data: dict[str, Any], *, notes: Sequence[str], script: tuple[str, str]
) -> str:
    """Return the page; no name in it is read as HTML or script."""
    code, look = script
    # "<" never stands in the data, so that nothing in it can end the script
    inside = json.dumps(data, ensure_ascii=False).replace("<", "\\u003c")
    code = code.replace("export default {", "const canvas = {")
    listed = "".join(f"<li>{html.escape(note)}</li>" for note in notes)
    n = len(notes)
    said = f"<details><summary>{n} correction{'s' * (n != 1)}</summary><ol>{listed}</ol></details>"
    head = html.escape(title)
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{head}</title><style>{_PAGE_STYLE}{look}</style></head>\n"
        f'<body><h1>{head}</h1>\n<div id="pawnb"></div>\n{said if notes else ""}\n'
        f'<script type="application/json" id="pawnb-data">{inside}</script>\n'
        f'<script type="module">\n{code}\n{read_static("page.js")}</script>\n</body></html>\n'
    )


def _evenly(first: int, last: int) -> list[int]:
    """Return all frames, or as many as a page has by itself."""
    n = last - first + 1
    if n <= MOST_PAGE_FRAMES:
        return list(range(first, last + 1))
    return sorted(
        {first + round(k * (n - 1) / (MOST_PAGE_FRAMES - 1)) for k in range(MOST_PAGE_FRAMES)}
    )


@checked_arguments
def export_page(
    trial: Trial | str | Path,
    tracks: Tracks,
    path: str | Path,
    *,
    frames: Sequence[int] | None = None,
    width: int = 1024,
    quality: int = 80,
    edits: str | Path | None = None,
) -> Path:
    """Write tracks over their pictures as one page that needs no Python, for a co-author.

    The page has the pictures of the chosen frames, everything that a reviewer draws over them,
    zoom, player and timeline, and the list of corrections. It is one file and fetches nothing.

    Parameters
    ----------
    trial : Trial, str or Path
        The trial, its ``trial.toml``, or the folder that holds it.
    tracks : xarray.Dataset
        Its tracks, of points or of a jointed animal.
    path : str or Path
        The page, ``.html``.
    frames : sequence of int, optional
        Which frames, for instance ``range(100, 160)``; default all, or 50 evenly spaced ones.
    width : int
        Most width of a view's picture, px.
    quality : int
        Of its JPEG, 1 to 100.
    edits : str or Path, optional
        Corrections to show; default ``results/edits.jsonl`` beside the trial.

    Returns
    -------
    Path
        The page.

    Raises
    ------
    InputError
        If a frame cannot be shown, or the trial, its tracks or the page cannot be used.

    Examples
    --------
    >>> pawnb.export_page(trial, tracks, "sample/page.html", frames=range(0, 10)).name
    'page.html'
    """
    from pawnb.core.pose.as_tracks import is_pose
    from pawnb.widgets.pose_reviewer import PoseReviewer
    from pawnb.widgets.track_reviewer import TrackReviewer

    kind = PoseReviewer if is_pose(tracks) else TrackReviewer
    review = kind(trial, tracks, edits=edits)
    try:
        return review.export_page(path, frames=frames, width=width, quality=quality)
    finally:
        review.close()
