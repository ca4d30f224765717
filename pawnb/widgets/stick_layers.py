"""What the published method makes of the picture, laid over it while its settings change.

Pullar 2009, §3.4.3 and Fig. 3.9: segmentation and shape prior, shown "to allow the user to
observe the effects of altering different parameter values".
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import cv2
import numpy as np

from pawnb.core.pose.background import Background
from pawnb.core.pose.pullar2009.energy_view import EnergyView, explain_energy
from pawnb.core.pose.pullar2009.settings import Pullar2009Settings
from pawnb.widgets.picture_layers import PictureLayers, shaded, slider
from pawnb.widgets.stick_session import StickSession

PULLAR_LAYERS = {
    "segmentation": "2009: segmentation",
    "shape_prior": "2009: shape prior",
    "background_cost": "2009: cost of background",
    "contrast": "2009: cost of a border",
}
PULLAR_SLIDERS = {
    "ising": "Ising term",
    "contrast": "Contrast term",
    "edge_grey": "Edge, grey values",
    "thickness_px": "Thickness, px",
    "steepness": "Steepness",
}
"""Settings with a slider: see :class:`pawnb.core.pose.pullar2009.settings.Pullar2009Settings`."""

_SLIDER_REACH = 5.0
"""Sliders reach so many times the estimated value."""
_FILL, _RIM_COLOURS = (86, 180, 233, 90), (255, 255, 255, 255)


class EnergyLayers(PictureLayers[np.ndarray, EnergyView]):
    """The terms of the published energy; settings that are not chosen are estimated."""

    names = PULLAR_LAYERS
    sliders_of = PULLAR_SLIDERS

    def __init__(self) -> None:
        super().__init__()
        self._estimated: dict[str, float] = {}

    @property
    def settings(self) -> Pullar2009Settings:
        """The settings tried, as ``track(..., method="paper")`` takes them."""
        return replace(Pullar2009Settings(), **dict[str, Any](self.chosen))

    def sliders(self) -> list[dict[str, Any]]:
        """Return a slider for each setting, once the first layer was looked at."""
        if not self.layer or not self._estimated:
            return []
        out = []
        for name, words in PULLAR_SLIDERS.items():
            usual = max(self._estimated[name], 1e-3)
            step = float(f"{usual / 50:.1g}")
            out.append(
                slider(
                    name,
                    words,
                    value=self.chosen.get(name, self._estimated[name]),
                    step=step,
                    limits=(step, step * round(_SLIDER_REACH * usual / step)),
                    title=f"{name} of method paper; estimated here: {usual:.3g}",
                )
            )
        return out

    def paint(self, view: EnergyView, layer: str) -> np.ndarray:
        """Paint one layer of an energy.

        Parameters
        ----------
        view : EnergyView
            The energy.
        layer : str
            A name of :data:`PULLAR_LAYERS`.

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
            out[(labels > 0) & (inner == 0)] = _bgra(_RIM_COLOURS)
            return out
        values = np.asarray(getattr(view, layer), dtype=float)
        if layer == "shape_prior":
            return shaded(values, opacity=values)
        low, high = np.percentile(values, [1, 99])
        return shaded((values - low) / max(high - low, 1e-9))

    def caption(self, view: EnergyView) -> str:
        """Return the energy."""
        return f"energy {view.energy:.0f}"

    def in_words(self, view: EnergyView) -> str:
        """Return the terms of an energy in words."""
        terms = ", ".join(f"{name} {value:.0f}" for name, value in view.terms.items())
        return f"Energy: {terms}."

    def _explain(
        self, session: StickSession, picture: np.ndarray, background: Background
    ) -> EnergyView:
        view = explain_energy(
            picture,
            session.pose.poses(session.pose_frame),
            animal=session.animal(),
            background=background,
            settings=self.settings,
        )
        if not self._estimated:
            self._estimated = {name: getattr(view.parameters, name) for name in PULLAR_SLIDERS}
        return view

    def _box(self, view: EnergyView) -> tuple[int, int, int, int]:
        return view.box


def _bgra(rgba: tuple[int, int, int, int]) -> tuple[int, int, int, int]:
    """Return a colour in the order of OpenCV."""
    red, green, blue, opacity = rgba
    return blue, green, red, opacity
