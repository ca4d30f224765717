"""What the published method makes of the picture, laid over it while its settings change.

Pullar 2009, §3.4.3 and Fig. 3.9: segmentation and shape prior, shown "to allow the user to
observe the effects of altering different parameter values".
"""

from __future__ import annotations

import base64
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import cv2
import numpy as np

from pawnb.core.pose.background import Background
from pawnb.core.pose.energy_view import EnergyView, explain_energy
from pawnb.core.pose.paper_settings import PaperPoseSettings
from pawnb.errors import InputError
from pawnb.widgets.stick_session import StickSession

LAYERS = {
    "segmentation": "Segmentation",
    "shape_prior": "Shape prior",
    "background_cost": "Cost of background",
    "contrast": "Cost of a border",
}
SETTINGS = {
    "ising": "Ising term",
    "contrast": "Contrast term",
    "edge_grey": "Edge, grey values",
    "thickness_px": "Thickness, px",
    "steepness": "Steepness",
}
"""Settings with a slider: see :class:`pawnb.core.pose.paper_settings.PaperPoseSettings`."""

_MOST = 5.0
"""Sliders reach so many times the estimated value."""
_FILL, _RIM = (86, 180, 233, 90), (255, 255, 255, 255)
_STRONG = 0.6
"""Opacity of a layer where it is strongest."""


class EnergyLayers:
    """One layer of the energy at a time, and the settings that a person tries.

    Attributes
    ----------
    layer : str
        A name of :data:`LAYERS`, or empty: nothing is shown.
    chosen : dict of str to float
        Settings that were changed; the others are estimated from the frame.
    """

    def __init__(self) -> None:
        self.layer = ""
        self.chosen: dict[str, float] = {}
        self._estimated: dict[str, float] = {}
        self._key: tuple[Any, ...] | None = None
        self._view: EnergyView | None = None

    @property
    def settings(self) -> PaperPoseSettings:
        """The settings tried, as ``track(..., method="paper")`` takes them."""
        return replace(PaperPoseSettings(), **dict[str, Any](self.chosen))

    def show(self, layer: str) -> None:
        """Choose a layer, or nothing; raises InputError for an unknown one."""
        if layer and layer not in LAYERS:
            raise InputError(f"layer {layer!r}: expected one of {', '.join(LAYERS)}, or nothing.")
        self.layer = layer

    def set(self, name: str, value: float) -> None:
        """Try another value of a setting; raises InputError for an unknown one."""
        if name not in SETTINGS:
            raise InputError(f"setting {name!r}: expected one of {', '.join(SETTINGS)}.")
        self.chosen[name] = value

    def reset(self) -> None:
        """Let every setting be estimated again."""
        self.chosen.clear()

    def look(
        self, session: StickSession, picture: np.ndarray, background: Background
    ) -> EnergyView:
        """Return the energy of the pose in a picture of its frame, computed once.

        Parameters
        ----------
        session : StickSession
            The pose.
        picture : ndarray, shape (H, W) or (H, W, 3), uint8
            The frame looked at.
        background : Background
            The empty scene.

        Returns
        -------
        EnergyView
            Its terms as pictures.
        """
        key = (session.frame, session.pose, dict(self.chosen))
        if self._view is None or not _same(key, self._key):
            self._view = explain_energy(
                picture,
                session.poses(),
                animal=session.animal(),
                background=background,
                settings=self.settings,
            )
            self._key = key
            if not self._estimated:
                self._estimated = {name: getattr(self._view.parameters, name) for name in SETTINGS}
        return self._view

    def tint(self, view: EnergyView) -> dict[str, Any]:
        """Return the chosen layer as the browser shows it: url and box."""
        pixels = paint_layer(view, self.layer)
        done, png = cv2.imencode(".png", pixels)
        if not done:
            raise InputError(f"the layer {self.layer} cannot be shown.")
        url = "data:image/png;base64," + base64.b64encode(png.tobytes()).decode("ascii")
        return {"url": url, "box": [int(x) for x in view.box]}

    def sliders(self) -> list[dict[str, Any]]:
        """Return a slider for each setting, once the first layer was looked at."""
        if not self.layer or not self._estimated:
            return []
        out = []
        for name, words in SETTINGS.items():
            usual = max(self._estimated[name], 1e-3)
            step = float(f"{usual / 50:.1g}")
            value = self.chosen.get(name, self._estimated[name])
            most = step * round(_MOST * usual / step)
            out.append(
                {
                    "id": name,
                    "text": words,
                    "min": step,
                    "max": float(f"{most:.6g}"),
                    "step": step,
                    "value": float(f"{value:.3g}"),
                    "title": f"{name} of method paper; estimated here: {usual:.3g}",
                }
            )
        return out


def paint_layer(view: EnergyView, layer: str) -> np.ndarray:
    """Paint one layer of an energy.

    Parameters
    ----------
    view : EnergyView
        The energy.
    layer : str
        A name of :data:`LAYERS`.

    Returns
    -------
    ndarray of uint8, shape (H, W, 4)
        Blue, green, red, opacity, as PNG writers of OpenCV take them.
    """
    if layer == "segmentation":
        labels = view.segmentation.astype(np.uint8)
        out = np.zeros((*labels.shape, 4), np.uint8)
        out[labels > 0] = _bgra(_FILL)
        inner = cv2.erode(labels, np.ones((3, 3), np.uint8))
        out[(labels > 0) & (inner == 0)] = _bgra(_RIM)
        return out
    values = np.asarray(getattr(view, layer), dtype=float)
    if layer == "shape_prior":
        share = values
    else:
        low, high = np.percentile(values, [1, 99])
        share = np.clip((values - low) / max(high - low, 1e-9), 0, 1)
    colours = cv2.applyColorMap((255 * share).round().astype(np.uint8), cv2.COLORMAP_VIRIDIS)
    opacity = 255 * _STRONG * (share if layer == "shape_prior" else np.ones_like(share))
    return np.dstack([colours, opacity.round().astype(np.uint8)])


def in_words(view: EnergyView) -> str:
    """Return the terms of an energy in words."""
    terms: Mapping[str, float] = view.terms
    return "Energy: " + ", ".join(f"{name} {value:.0f}" for name, value in terms.items()) + "."


def _same(now: tuple[Any, ...], before: tuple[Any, ...] | None) -> bool:
    """Say whether frame, pose (the very object) and settings are those of before."""
    if before is None:
        return False
    return now[0] == before[0] and now[1] is before[1] and now[2] == before[2]


def _bgra(rgba: tuple[int, int, int, int]) -> tuple[int, int, int, int]:
    """Return a colour in the order of OpenCV."""
    red, green, blue, opacity = rgba
    return blue, green, red, opacity
