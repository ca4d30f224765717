"""The one canvas that shows video in a notebook; every widget stands on it.

All views of a trial are shown at the same frame. Pictures travel as JPEG in binary
messages, as small as the screen can show; points, trails and lines are drawn in the
browser. Of ``static``, ``connection.js`` knows whether Python hears the browser, ``stage.js`` is
one view, ``marks.js`` what is drawn over it, ``linked.js`` how other views see a point in the hand,
``closer.js`` the loupe and the zoom that follows a point,
``stick.js`` a stick animal, ``frames.js`` the traffic of frames, ``controls.js`` buttons and
sliders, ``keys.js`` the keys, ``timeline.js``, ``lanes.js`` and ``stretch_bar.js`` the timeline
where there is one (see ``timeline.py``), ``sheet.js`` the sheet of questions, ``frame_canvas.js``
the page; they are joined here,
without any build step.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, Literal, Protocol

import anywidget
import cv2
import numpy as np
import traitlets

from pawnb.core.rig import Rig
from pawnb.core.video.views import Frame
from pawnb.errors import InputError, PawnbError
from pawnb.widgets.page import Paged, as_text
from pawnb.widgets.plain import Plain, picture_of_canvas
from pawnb.widgets.surroundings import read_static

Overlay = dict[str, Any]
"""``{"views": {name: {"points", "hollow", "lines", "chips"}}, "caption", "current"}``, plain
JSON. Points and hollow marks have id, u, v, colour (and origin); lines have at (a list of
[u, v], None for a gap), colour, and dash or fade; chips have id, state, title, colour.
A view may also have ``others``, points of a second track (id, u, v, colour); ``stick``, a stick
animal whose handles can be dragged (:func:`pawnb.widgets.stick_session.describe`); ``tint``, a
picture over part of it: url (``data:image/png;base64,...``) and box (u0, v0, u1, v1, half open);
``asks``, the point that a click there places, or None; ``guides``, where the other views put points
(name to [[u, v]], or to the two ends of a line), with ``limit_px``, how far from there is too far,
and ``residuals``, whether the distance is always shown. Beside the views ``look`` may stand: the
part of each view that is shown from now on, id and views (name to [u, v, width])."""

MOUSE_AND_KEYS = (
    (
        "Wheel",
        "zoom in and out about the mouse, once the widget was clicked; else with Ctrl or Cmd",
    ),
    ("Shift and drag", "zoom into a rectangle (Z, then drag, does the same)"),
    ("Drag the picture", "move a zoomed picture"),
    ("V", "every view follows the chosen point, and zooms with the others; 0 ends it"),
    ("U", "a loupe at the mouse"),
    (
        "E",
        "place the point that a click would place, where the other views put it or in the middle",
    ),
    ("0", "show every view whole again"),
    ("Left, Right", "one frame back or on; ten with Shift"),
    ("Home, End", "first and last frame"),
    ("G", "go to a frame by its number"),
    (
        "Space",
        "play or stop; B plays backwards, Shift+Space in a loop (the chosen stretch, or all)",
    ),
    ("+, -", "play faster, slower"),
    ("Alt and an arrow", "the chosen point by 1 px; with Shift by 0.1 px"),
    ("?", "this list"),
    ("Esc", "let go of a point: it stays where it was"),
)

NO_PLACING = tuple(line for line in MOUSE_AND_KEYS if line[0] != "E")
"""The same where a click places nothing."""


class FramePicture(Protocol):
    """A frame of a view; :class:`pawnb.core.video.Frame` is one."""

    def image(self) -> np.ndarray:
        """Return the whole view, (H, W, 3) RGB or (H, W) grey, uint8."""


class ViewSource(Protocol):
    """What is asked of views; :class:`pawnb.core.video.ViewSet` has it."""

    @property
    def names(self) -> Sequence[str]:
        """Names of the views."""

    @property
    def readers(self) -> Mapping[str, Any]:
        """Reader of each view, with ``width`` and ``height`` in px."""

    @property
    def n_frames(self) -> int:
        """One past the last frame."""

    def frame(self, index: int, /) -> Mapping[str, FramePicture]:
        """Return one frame of every view."""


class FrameCanvas(Paged, Plain, anywidget.AnyWidget):
    """All views of a trial at one frame, with zoom, play and what is drawn over them.

    Parameters
    ----------
    views : ViewSet
        Open views, for instance of :func:`pawnb.core.video.open_views`. They must stay open.
    overlay : callable, optional
        ``overlay(frame)`` gives what is drawn over a frame; see :data:`Overlay`.
    **options
        ``frame`` (first frame to show), ``span`` (first and last frame that can be shown),
        ``quality`` (of JPEG, 1 to 100), ``transport`` (``"binary"``, or ``"base64"`` for
        front ends that lose binary messages; the browser changes to it by itself when a
        picture arrives empty), ``max_height`` (of all views together, CSS px).

    Attributes
    ----------
    frame : int
        The frame that is shown; can be set and observed.
    selected : list of str
        View and point that are chosen, or empty; can be set and observed.
    cameras : dict of str to list of float
        DLT coefficients of calibrated views: while a point is dragged in one, the others show at
        once where it lies in them.

    Raises
    ------
    InputError
        If the frame is not in the recording, or an option is unknown.
    """

    _esm = read_static(
        "connection.js", "stick.js", "linked.js", "closer.js", "marks.js", "stage.js", "frames.js",
        "controls.js", "keys.js", "stretch_bar.js", "lanes.js", "timeline.js", "sheet.js",
        "frame_canvas.js",
    )  # fmt: skip
    _css = read_static("frame_canvas.css")

    stages: traitlets.List = traitlets.List().tag(sync=True)
    span: traitlets.List = traitlets.List().tag(sync=True)
    frame = traitlets.Int(0).tag(sync=True)
    status = traitlets.Unicode("").tag(sync=True)
    alarm = traitlets.Unicode("").tag(sync=True)
    actions: traitlets.List = traitlets.List().tag(sync=True)
    sliders: traitlets.List = traitlets.List().tag(sync=True)
    keys_help: traitlets.List = traitlets.List().tag(sync=True)
    label = traitlets.Unicode("Video frames").tag(sync=True)
    selected: traitlets.List = traitlets.List().tag(sync=True)
    transport = traitlets.Unicode("binary").tag(sync=True)
    max_height = traitlets.Int(720).tag(sync=True)
    cameras: traitlets.Dict = traitlets.Dict().tag(sync=True)
    tell_selected = traitlets.Bool(default_value=False).tag(sync=True)

    def __init__(
        self,
        views: ViewSource,
        *,
        overlay: Callable[[int], Overlay] | None = None,
        frame: int | None = None,
        span: tuple[int, int] | None = None,
        quality: int = 85,
        transport: Literal["binary", "base64"] = "binary",
        max_height: int = 720,
    ) -> None:
        self._views = views
        self._overlay = overlay
        self._quality = quality
        self._version = 0
        # callbacks may run off the main thread, and two may run at once
        self._video_lock = threading.Lock()
        self._edit_lock = threading.RLock()
        whole = (getattr(views, "first_frame", 0), views.n_frames - 1)
        first, last = span or whole
        if not whole[0] <= first <= last <= whole[1]:
            raise InputError(
                f"span is {first} to {last}; expected frames of the recording, {whole[0]} to "
                f"{whole[1]}, the first one first."
            )
        frame = first if frame is None else frame
        _check_frame(frame, (first, last))
        workers = min(4, os.cpu_count() or 1)
        self._pool = ThreadPoolExecutor(workers, thread_name_prefix="pawnb-jpeg")
        # frames are read beside the thread that hears the browser: Jupyter has told all pages that
        # the kernel is busy, and no more, before the picture comes
        self._readers = ThreadPoolExecutor(1, thread_name_prefix="pawnb-frames")
        sizes = {name: views.readers[name] for name in views.names}
        super().__init__(
            stages=[{"name": n, "width": r.width, "height": r.height} for n, r in sizes.items()],
            span=[int(first), int(last)],
            frame=int(frame),
            transport=transport,
            max_height=max_height,
            keys_help=[list(line) for line in MOUSE_AND_KEYS],
        )
        self.on_msg(self._receive)

    # --- for the widgets that stand on this one -----------------------------------------

    def overlay(self, frame: int) -> Overlay:
        """Return what is drawn over a frame; see :data:`Overlay`."""
        return self._overlay(frame) if self._overlay is not None else {"views": {}}

    def edit(self, what: str, message: Mapping[str, Any]) -> int | None:
        """Do what a person asked for; nothing in a canvas that only shows.

        Parameters
        ----------
        what : str
            click, moved, hide, select, action or stretch.
        message : mapping
            ``frame`` and, as it applies, ``view``, ``point``, ``u``, ``v``, ``whole`` (no Ctrl key
            was held while dragging), ``action``, ``value`` (of a menu or a slider), ``selected``
            ([view, point] or None).

        Returns
        -------
        int or None
            A frame that the browser should show next.
        """

    def _tell(self, status: str, actions: Sequence[Mapping[str, Any]]) -> None:
        """Tell the browser what can be pressed, and last what was done.

        A key is not heard while its button is off: who reads that something is done, and presses
        at once, finds the buttons on.
        """
        self.actions = list(actions)
        self.status = status

    def link_views(self, rig: Rig | None) -> None:
        """Show in the other views of a rig where a point lies that is dragged in one of them."""
        columns = () if rig is None else zip(rig.names, rig.coefs.T.tolist(), strict=True)
        self.cameras = dict(columns)

    def refresh(self, go: int | None = None) -> None:
        """Let the browser ask again for what is drawn, and go to a frame."""
        with self._edit_lock:
            self._version += 1
            self.send({"type": "refresh", "version": self._version, "go": go})

    def plain_picture(self) -> bytes:
        """Return the views at the frame that is shown, with what is drawn over them, as PNG."""
        return picture_of_canvas(self)

    def plain_legs(self, frame: int) -> dict[str, list[tuple[np.ndarray, str]]]:  # noqa: ARG002
        """Return legs of a stick animal for the plain picture: places (m, 2) px and colour."""
        return {}

    def close(self) -> None:
        """Take the widget away and end its threads; the views stay open."""
        if hasattr(self, "_pool"):  # also called for a widget that was refused half made
            self._readers.shutdown(wait=False, cancel_futures=True)
            self._pool.shutdown(wait=False, cancel_futures=True)
        super().close()

    @traitlets.validate("frame")
    def _frame_of_the_span(self, proposal: Any) -> int:
        """Refuse a frame that cannot be shown, also where it is set later."""
        if self.span:  # empty while the widget is being made, which looks at its frame itself
            _check_frame(proposal["value"], self.span)
        return int(proposal["value"])

    @traitlets.validate("selected")
    def _selected_in_a_view(self, proposal: Any) -> list[str]:
        """Refuse what is no view and point."""
        given = list(proposal["value"])
        views = [stage["name"] for stage in self.stages]
        if given and (len(given) != 2 or given[0] not in views):
            raise InputError(
                f"selected is {given}; expected a view of {', '.join(views)} and a point, or []."
            )
        return [str(word) for word in given]

    # --- messages -----------------------------------------------------------------------

    def _receive(self, _widget: Any, message: dict[str, Any], _buffers: Any) -> None:
        """Answer one message of the browser."""
        if message.get("type") == "want":
            for frame in message["frames"]:
                self._readers.submit(self._answer_want, int(frame), message)
        elif message.get("type") == "edit":
            self._answer_edit(message)
        elif message.get("type") == "hello":
            self.send({"type": "hello", "who": message["who"]})

    def _answer_want(self, frame: int, message: dict[str, Any]) -> None:
        """Send a frame: its pictures, unless the browser has them, and its overlay."""
        answer: dict[str, Any] = {"type": "frame", "who": message["who"], "frame": frame}
        pictures: list[bytes] = []
        try:
            if message["pixels"]:
                pictures = self._encode(frame, message["shrink"])
            with self._edit_lock:
                answer |= {"version": self._version, "overlay": self.overlay(frame)}
        except Exception as error:  # noqa: BLE001, in this thread nobody else would hear of it
            named = f"frame {frame} cannot be shown: {type(error).__name__}: {error}"
            self.alarm = answer["error"] = str(error) if isinstance(error, PawnbError) else named
            pictures = []
        answer |= {"sent": bool(pictures), "shrink": message["shrink"]}
        if pictures and message.get("plain"):
            answer["pictures"] = [as_text(data) for data in pictures]
            self.send(answer)
        else:
            self.send(answer, buffers=pictures)

    def _answer_edit(self, message: dict[str, Any]) -> None:
        """Do what was asked and say that it is done; the browser waits for that."""
        frame, go = int(message["frame"]), None
        with self._edit_lock:
            try:
                self.alarm = ""
                go = self.edit(message["what"], message)
            except (PawnbError, OSError) as error:
                self.alarm = str(error)
            finally:
                self._version += 1
                answer = {"type": "done", "who": message["who"], "n": message["n"], "go": go}
                answer |= {"version": self._version, "frame": frame}
                self.send(answer | {"overlay": self.overlay(frame)})

    def _encode(
        self, frame: int, shrink: Sequence[float], *, quality: int | None = None
    ) -> list[bytes]:
        """Return one JPEG a view, each made ``shrink`` times smaller, in the order of views."""
        with self._video_lock:
            frames = self._views.frame(frame)
        names = self._views.names
        quality = self._quality if quality is None else quality
        jobs = [
            self._pool.submit(encode_jpeg, frames[name], shrink=float(k), quality=quality)
            for name, k in zip(names, shrink, strict=True)
        ]
        return [job.result() for job in jobs]


def _check_frame(frame: int, span: Sequence[int]) -> None:
    """Raise InputError for a frame that cannot be shown."""
    first, last = span
    if not first <= frame <= last:
        raise InputError(f"frame {frame} is not in the recording ({first} to {last}).")


def encode_jpeg(picture: FramePicture, *, shrink: float = 1, quality: int = 85) -> bytes:
    """Encode a frame as JPEG.

    Parameters
    ----------
    picture : Frame
        Anything with ``image()`` that gives (H, W, 3) RGB or (H, W) grey, uint8.
    shrink : float
        How many times smaller it becomes along each side, from 1 on.
    quality : int
        1 to 100.

    Returns
    -------
    bytes
        The JPEG file.

    Raises
    ------
    InputError
        If the picture cannot be encoded.
    """
    image = _smaller(picture, shrink)
    if image.ndim == 3:
        image = cv2.cvtColor(image, cv2.COLOR_RGB2BGR)
    done, data = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, quality])
    if not done:
        height, width = image.shape[:2]
        raise InputError(f"a picture of {width} x {height} px cannot be encoded as JPEG.")
    return data.tobytes()


def _smaller(picture: FramePicture, shrink: float) -> np.ndarray:
    """Return a picture ``shrink`` times smaller: of a frame, as far as it goes before it is RGB."""
    if not isinstance(picture, Frame):
        image = picture.image()
        return _resized(image, image.shape[1::-1], shrink, cv2.INTER_AREA)
    whole = 4 if shrink >= 4 else 2 if shrink >= 2 else 1
    image = picture.shrunk(whole)
    if whole == shrink:
        return image
    # what is left is less than twofold: between four neighbours nothing is skipped
    return _resized(image, (picture.width, picture.height), shrink, cv2.INTER_LINEAR)


def _resized(
    image: np.ndarray, whole: Sequence[int], shrink: float, interpolation: int
) -> np.ndarray:
    """Return a picture ``shrink`` times smaller than a whole one of that width and height."""
    size = [max(1, round(side / shrink)) for side in whole]
    return np.asarray(cv2.resize(image, size, interpolation=interpolation))
