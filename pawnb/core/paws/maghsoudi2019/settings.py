"""Settings of the 2019 paw tracker, method ``paper``."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Literal

from pawnb.errors import InputError
from pawnb.schema import check_ranges

REFERENCE_WIDTH_PX = 2048
"""Definition: width of the paper's pictures, for which the lengths in px are given."""

N_FEATURES = 8
"""Definition: the features of Eq. 3."""

PUBLISHED_NAMES = {
    "NumSLIC": "n_superpixels",
    "mnop": "min_paw_area_px",
    "PawXWindowSize": "window_u_px",
    "PawYWindowSize": "window_v_px",
    "Weights_F": "weights_front",
    "Weights_H": "weights_hind",
    "Collision_Threshold": "collision_threshold_px",
    "Start_Frame_Collision": "start_frame_collision",
}
"""The paper's names of settings, to ours; ``docs/published_methods.md`` has the same."""

_PAW = re.compile(
    r"(?:(?i:left|right)[_ .-]?)?(?:(?=[FH][RL])|(?=[fh][rl]?(?![A-Za-z]))|(?=[FH](?![A-Za-z]))"
    r"|(?=(?i:front|fore(?!head)|hind)))(\w)|(?:[RL](?=[FH](?![A-Za-z]))|[rl](?=[fh](?![A-Za-z])))(\w)"
)


@dataclass(frozen=True, kw_only=True)
class Maghsoudi2019Settings:
    """Settings of Haji Maghsoudi et al. 2019, section 3.2, and of the steps around them.

    The name that the paper uses is given in brackets. Lengths and areas are those of
    the paper's pictures, 2048 px wide; ``scale`` brings them to yours.

    Parameters
    ----------
    scale : float, optional
        Factor on every length in px below (areas go with its square). Default: the
        width of the view's picture / 2048. Set it where that is no measure of the size of
        the animal: for a cropped view, or a camera much nearer than the paper's.
    window_u_px : float
        Half the width of the sub-image (PawXWindowSize, 70).
    window_v_px : float
        Half the height of the sub-image (PawYWindowSize, 40).
    median_px : float
        Size of the median filter, rounded to the nearest odd number; 1 or less is no
        filter. The paper names the filter but not its size.
    min_paw_area_px : float
        Fewest pixels that a paw covers (mnop of Eq. 10, 50). Eq. 10 gives the number of
        superpixels of a sub-image from it: rows × columns / (2 × area), 112 for 140 × 80.
    n_superpixels : int, optional
        Number of superpixels of a whole sub-image, instead of Eq. 10. The paper's
        NumSLIC (15,000) counts those of the whole picture: multiply it by the area of the
        sub-image / the area of the picture (15,000 × 140 × 80 / (2048 × 700) = 117).
    slic_compactness : float
        Weight of nearness against likeness of colour in SLIC (scikit-image's 10).
    slic_sigma_px : float
        Gaussian smoothing before SLIC; 0 is none. Not scaled.
    slic_iterations : int
        Iterations of SLIC's k-means (scikit-image's 10).
    weights_front, weights_hind : tuple of 8 float
        Weights of the eight features (Weights_F and Weights_H, Eq. 5): green at the
        start and in the frame before, hue likewise, red likewise, distance from the
        bottom corner towards the direction of travel, distance from the prediction.
    weights_other : tuple of 8 float
        Those of landmarks that are no paws (nose, ears, tail, marks on the back), of which the
        paper says nothing: the front paws', but no pull towards the corner, which is
        where the tip of a paw is.
    front, hind : tuple of str
        Points that use each set of weights. Points named in neither are sorted by
        :meth:`kind`.
    n_best : int
        Number of best superpixels that are kept (the paper's three).
    process_var, measurement_var, initial_var : float
        Noise of the Kalman filter; the defaults are OpenCV's, as in the paper. See
        :func:`pawnb.core.kalman.make_model`.
    hidden : {"search", "wait"}
        What is done about a point in a view where it was not clicked. ``"search"`` looks
        for it where the other views say that it is; ``"wait"`` leaves it until it is
        placed there by hand. The paper has every paw clicked in every view.
    hidden_distance_px : float
        ``"search"`` accepts a superpixel no farther than this from where the other views
        place the point.
    hidden_difference : float
        ``"search"`` accepts a superpixel whose colour differs from the point's by no more
        than this: root mean square of the differences in green, red (of 255) and hue (of
        180°).
    collision_threshold_px : float
        Front and hind paw of a side nearer to each other than this collide, type II
        (Collision_Threshold, 60). How far a paw may be from its prediction during a
        collision goes with it.
    start_frame_collision : int
        Frames that must have been tracked before a collision of type II is looked for, as
        the template cannot be fitted to fewer (Start_Frame_Collision, 20).
    adjust_weights : bool
        Change the weights during a collision of type II (Algorithm 4, an optional step).
    template_predicts : {"lost", "always"}
        Which paws the template predicts during a collision of type II: those that are not
        found, or both as long as it lasts, as Algorithm 3 has it. See
        :mod:`pawnb.core.paws.maghsoudi2019.collisions`.
    template : str, optional
        File of the stride template, made by :mod:`pawnb.workflow.stride_template`; default
        the one that comes with pawnb.
    template_cutoff_hz : float
        Cut-off of the low-pass filter before the template is fitted. The paper sets it by
        the highest frequency of the paws, 10 Hz, and gives no number.
    jump_residual_px : float
        A front paw whose reprojection error exceeds this after a collision of type II has
        jumped to another paw, type III. The paper speaks of a significant error.

    Raises
    ------
    InputError
        If a value is out of range.
    """

    scale: float | None = None
    window_u_px: float = 70.0
    window_v_px: float = 40.0
    median_px: float = 5.0
    min_paw_area_px: float = 50.0
    n_superpixels: int | None = None
    slic_compactness: float = 10.0
    slic_sigma_px: float = 0.0
    slic_iterations: int = 10
    weights_front: tuple[float, ...] = (2, 0, 4, 2, 2, 0, 1, 4)
    weights_hind: tuple[float, ...] = (2, 0, 4, 1, 2, 0, 2, 4)
    weights_other: tuple[float, ...] = (2, 0, 4, 2, 2, 0, 0, 4)
    front: tuple[str, ...] = ()
    hind: tuple[str, ...] = ()
    n_best: int = 3
    process_var: float = 1.0
    measurement_var: float = 1.0
    initial_var: float = 0.0
    hidden: Literal["search", "wait"] = "search"
    hidden_distance_px: float = 20.0
    hidden_difference: float = 0.1
    collision_threshold_px: float = 60.0
    start_frame_collision: int = 20
    adjust_weights: bool = True
    template_predicts: Literal["lost", "always"] = "lost"
    template: str | None = None
    template_cutoff_hz: float = 30.0
    jump_residual_px: float = 10.0

    def __post_init__(self) -> None:
        """Check the ranges."""
        check_ranges(
            self,
            above_0=(
                "window_u_px", "window_v_px", "min_paw_area_px", "slic_compactness",
                "slic_iterations", "n_best", "measurement_var", "start_frame_collision",
                "template_cutoff_hz", "jump_residual_px", "scale", "n_superpixels",
            ),
            least_0=(
                "process_var", "initial_var", "slic_sigma_px", "median_px", "hidden_distance_px",
                "hidden_difference", "collision_threshold_px",
            ),
        )  # fmt: skip
        for name in ("weights_front", "weights_hind", "weights_other"):
            weights = getattr(self, name)
            if len(weights) != N_FEATURES or min(weights) < 0 or not sum(weights) > 0:
                raise InputError(
                    f"setting {name!r} is {list(weights)}; expected {N_FEATURES} numbers, none "
                    "below 0 and not all 0."
                )
        both = sorted(set(self.front) & set(self.hind))
        if both:
            raise InputError(
                f"setting 'front' and setting 'hind' both name {', '.join(both)}; "
                "keep each point in one."
            )

    def weights(self, point: str) -> tuple[float, ...]:
        """Return the eight weights of a point, by its kind."""
        weights = {"front": self.weights_front, "hind": self.weights_hind}
        return weights.get(self.kind(point), self.weights_other)

    def kind(self, point: str) -> str:
        """Return ``"front"``, ``"hind"`` or ``"other"`` for a point.

        What ``front`` and ``hind`` name comes first; else F or H alone or with R or L, as in
        the mouse's FR, FL, HR, HL or in LF, RH, and names that begin with front, fore or hind,
        with or without left or right before it. Others, such as head, forehead, hip or flank,
        are landmarks.
        """
        if point in self.front:
            return "front"
        if point in self.hind:
            return "hind"
        found = _PAW.match(point)
        if found is None:
            return "other"
        return {"f": "front", "h": "hind"}[(found[1] or found[2]).lower()]


@dataclass(frozen=True)
class Lengths:
    """The settings' lengths and areas in the pixels of one view.

    Parameters
    ----------
    half_u, half_v : float
        Half the width and height of the sub-image.
    median : int
        Size of the median filter, odd; 1 is none.
    paw_area : float
        Fewest pixels that a paw covers.
    hidden_distance : float
        Distance within which a hidden point is accepted.
    collision : float
        Distance within which paws of a side collide.
    jump_residual : float
        Reprojection error beyond which a paw has jumped.
    """

    half_u: float
    half_v: float
    median: int
    paw_area: float
    hidden_distance: float
    collision: float
    jump_residual: float


def lengths_in_view(settings: Maghsoudi2019Settings, width: int) -> Lengths:
    """Bring the settings' lengths to the pixels of a view.

    Parameters
    ----------
    settings : Maghsoudi2019Settings
        The settings.
    width : int
        Width of the view's picture, px.

    Returns
    -------
    Lengths
        Lengths × scale and areas × scale².
    """
    scale = width / REFERENCE_WIDTH_PX if settings.scale is None else settings.scale
    median = round((settings.median_px * scale - 1) / 2) * 2 + 1
    return Lengths(
        half_u=settings.window_u_px * scale,
        half_v=settings.window_v_px * scale,
        median=max(median, 1),
        paw_area=settings.min_paw_area_px * scale**2,
        hidden_distance=settings.hidden_distance_px * scale,
        collision=settings.collision_threshold_px * scale,
        jump_residual=settings.jump_residual_px * scale,
    )
