"""One layer at a time over the picture, and the settings that a person tries with it."""

from __future__ import annotations

import base64
from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, Generic, TypeVar

import cv2
import numpy as np

from pawnb.core.pose.background import Background
from pawnb.errors import InputError
from pawnb.widgets.stick_session import StickSession

ViewT = TypeVar("ViewT")
PictureT = TypeVar("PictureT")

_STRONG = 0.6
"""Opacity of a layer where it is strongest."""


class PictureLayers(ABC, Generic[PictureT, ViewT]):
    """What a method makes of a frame, as pictures, while its settings change.

    Attributes
    ----------
    names : mapping of str to str
        Layers, and what they are called.
    sliders_of : mapping of str to str
        Settings that a person may try, and what they are called.
    layer : str
        The layer that is shown, or empty: none.
    chosen : dict of str to float
        Settings that were changed.
    """

    names: Mapping[str, str]
    sliders_of: Mapping[str, str]

    def __init__(self) -> None:
        self.layer = ""
        self.chosen: dict[str, float] = {}
        self._key: tuple[Any, ...] | None = None
        self._view: ViewT | None = None

    def show(self, layer: str) -> None:
        """Choose a layer, or nothing; raises InputError for an unknown one."""
        if layer and layer not in self.names:
            raise InputError(
                f"layer {layer!r}: expected one of {', '.join(self.names)}, or nothing."
            )
        self.layer = layer

    def set(self, name: str, value: float) -> None:
        """Try another value of a setting; raises InputError for an unknown one."""
        if name not in self.sliders_of:
            raise InputError(f"setting {name!r}: expected one of {', '.join(self.sliders_of)}.")
        self.chosen[name] = value

    def reset(self) -> None:
        """Let every setting be what it was."""
        self.chosen.clear()

    def look(self, session: StickSession, picture: PictureT, background: Background) -> ViewT:
        """Return what the method makes of the pose in a picture of its frame, computed once.

        Parameters
        ----------
        session : StickSession
            The pose.
        picture : ndarray or Frame
            The frame looked at, as the method takes it.
        background : Background
            The empty scene.

        Returns
        -------
        EnergyView or FitView
            Its parts as pictures.
        """
        key = (session.frame, session.pose, dict(self.chosen))
        if self._view is None or not _same(key, self._key):
            self._view = self._explain(session, picture, background)
            self._key = key
        return self._view

    def tint(self, view: ViewT) -> dict[str, Any]:
        """Return the chosen layer as the browser shows it: url and box."""
        done, png = cv2.imencode(".png", self.paint(view, self.layer))
        if not done:
            raise InputError(f"the layer {self.layer} cannot be shown.")
        url = "data:image/png;base64," + base64.b64encode(png.tobytes()).decode("ascii")
        return {"url": url, "box": [int(x) for x in self._box(view)]}

    @abstractmethod
    def paint(self, view: ViewT, layer: str) -> np.ndarray:
        """Paint one layer, uint8 (H, W, 4): blue, green, red, opacity."""

    @abstractmethod
    def sliders(self) -> list[dict[str, Any]]:
        """Return a slider for each setting, while a layer is shown."""

    @abstractmethod
    def caption(self, view: ViewT) -> str:
        """Return a number that says how well the pose explains the picture."""

    @abstractmethod
    def in_words(self, view: ViewT) -> str:
        """Return what the method makes of the pose, in words."""

    @abstractmethod
    def _explain(self, session: StickSession, picture: PictureT, background: Background) -> ViewT:
        """Compute the view."""

    @abstractmethod
    def _box(self, view: ViewT) -> tuple[int, int, int, int]:
        """Return where the pictures lie, px of the view, half open."""


def shaded(share: np.ndarray, *, opacity: np.ndarray | None = None) -> np.ndarray:
    """Return shares of 0 to 1 as colours from dark to light.

    Parameters
    ----------
    share : ndarray, shape (H, W)
        Values, cut at 0 and 1.
    opacity : ndarray, shape (H, W), optional
        0 to 1; default 1 everywhere. The strongest still lets the picture through.

    Returns
    -------
    ndarray of uint8, shape (H, W, 4)
        Blue, green, red, opacity.
    """
    share = np.clip(share, 0, 1)
    colours = cv2.applyColorMap((255 * share).round().astype(np.uint8), cv2.COLORMAP_VIRIDIS)
    alpha = 255 * _STRONG * (np.ones_like(share) if opacity is None else np.clip(opacity, 0, 1))
    return np.dstack([colours, alpha.round().astype(np.uint8)])


def slider(
    name: str, text: str, *, value: float, step: float, limits: tuple[float, float], title: str
) -> dict[str, Any]:
    """Return one slider as ``static/frame_canvas.js`` takes it.

    Parameters
    ----------
    name : str
        Name by which its changes come back.
    text : str
        Words beside it.
    value, step : float
        Where it stands, and by how much it moves.
    limits : tuple of float
        Least and greatest value.
    title : str
        What is shown where the pointer rests.

    Returns
    -------
    dict
        The slider.
    """
    return {
        "id": name, "text": text, "min": limits[0], "max": float(f"{limits[1]:.6g}"),
        "step": step, "value": float(f"{value:.3g}"), "title": title,
    }  # fmt: skip


def _same(now: tuple[Any, ...], before: tuple[Any, ...] | None) -> bool:
    """Say whether frame, pose (the very object) and settings are those of before."""
    if before is None:
        return False
    return now[0] == before[0] and now[1] is before[1] and now[2] == before[2]
