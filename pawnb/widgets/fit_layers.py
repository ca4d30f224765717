"""What the default method sees in the picture and would paint, while its settings change."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from pawnb.core.pose.background import Background
from pawnb.core.pose.fit.explanation import FitView, explain_fit
from pawnb.core.pose.fit.settings import PoseSettings
from pawnb.core.video.views import Frame
from pawnb.widgets.picture_layers import PictureLayers, shaded, slider
from pawnb.widgets.stick_session import StickSession

FIT_LAYERS = {
    "darkness": "What is dark",
    "painted": "The animal as painted",
    "unexplained": "What stays unexplained",
}
FIT_SLIDERS = {
    "working_span_px": ("Working leg span, px", 5.0, (50.0, 600.0)),
    "blur_px": ("Blur, working px", 0.05, (0.1, 4.0)),
    "unexplained_sd": ("Unexplained darkness, SD", 0.01, (0.01, 0.5)),
    "soft_error": ("Soft error", 0.05, (0.1, 2.0)),
}
"""Settings with a slider that show in a single frame, with step and limits; see
:class:`pawnb.core.pose.fit.settings.PoseSettings`."""

_FAINT, _PLAIN = 0.08, 0.5
"""Darkness from which a layer begins to show, and from which it shows in full."""
_POOR = 0.6
"""Legs that are explained less are named."""


class FitLayers(PictureLayers[Frame, FitView]):
    """Evidence, model and difference of method ``pawnb``."""

    names = FIT_LAYERS
    sliders_of = {name: words for name, (words, _, _) in FIT_SLIDERS.items()}  # noqa: RUF012

    @property
    def settings(self) -> PoseSettings:
        """The settings tried, as ``track(..., method="pawnb")`` takes them."""
        return replace(PoseSettings(), **dict[str, Any](self.chosen))

    def sliders(self) -> list[dict[str, Any]]:
        """Return a slider for each setting."""
        if not self.layer:
            return []
        usual = PoseSettings()
        return [
            slider(
                name,
                words,
                value=self.chosen.get(name, getattr(usual, name)),
                step=step,
                limits=limits,
                title=f"{name} of method pawnb; default {getattr(usual, name):g}",
            )
            for name, (words, step, limits) in FIT_SLIDERS.items()
        ]

    def paint(self, view: FitView, layer: str) -> np.ndarray:
        """Paint one layer of a fit, uint8 (H, W, 4): blue, green, red, opacity."""
        values = np.clip(np.asarray(getattr(view, layer), dtype=float), 0, 1)
        # noise lets the picture through, and half of an animal's darkness is seen well
        return shaded(values, opacity=(values - _FAINT) / (_PLAIN - _FAINT))

    def caption(self, view: FitView) -> str:
        """Return the cost."""
        return f"cost {view.cost:.0f}"

    def in_words(self, view: FitView) -> str:
        """Return how well the legs are explained."""
        poor = {leg: share for leg, share in view.support.items() if share < _POOR}
        if not poor:
            return f"Every leg is explained to {100 * min(view.support.values()):.0f} % or more."
        named = ", ".join(f"{leg} to {100 * share:.0f} %" for leg, share in poor.items())
        return f"Poorly explained: {named}."

    def _explain(self, session: StickSession, picture: Frame, background: Background) -> FitView:
        return explain_fit(
            picture,
            session.pose.poses(session.pose_frame),
            animal=session.animal(),
            background=background,
            settings=self.settings,
        )

    def _box(self, view: FitView) -> tuple[int, int, int, int]:
        return view.box
