"""Settings of the 2009 pose tracker, and the parameters of its energy."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.pullar2009.parameters import PULLAR2009
from pawnb.schema import check_ranges

PUBLISHED_NAMES = {
    "K": "ising",
    "lambda": "contrast",
    "d_r": "thickness_px",
    "mu": "steepness",
}
"""The thesis's names of settings, to ours; ``docs/published_methods.md`` has the same."""


@dataclass(frozen=True, kw_only=True)
class Pullar2009Settings:
    """What can be set of ``method="paper"`` for a jointed animal (Pullar 2009, chapter 3).

    Parameters
    ----------
    ising : float, optional
        Cost of two neighbours with different labels (K, Eq. 3.10). Default: half of sigma, the
        standard deviation of the background's cost in the start frame (Table 3.3).
    contrast : float, optional
        Greatest further cost of different neighbours, where the picture is flat (lambda,
        Eq. 3.11). Default: twice sigma.
    edge_grey : float, optional
        Gradient (of Sobel's operator, Eq. 3.13) at which ``contrast`` has fallen to 61 %
        (the sigma of Eq. 3.11, which the thesis does not define). Default: sigma, the natural
        reading of Table 3.3.
    thickness_px : float, optional
        Distance from the stick animal at which a pixel is as likely subject as background
        (d_r, "body size", Eq. 3.15). Default: leg span / 200.
    steepness : float, optional
        Cost of a subject pixel for each px further than that (mu, Eq. 3.15). Default:
        sigma / d_r.
    subject : {"background mean", "gaussian"}
        Cost of a subject pixel: the mean of the background's cost over the frame, which the
        thesis uses in the end, or that of a Gaussian with mean and standard deviation of the
        subject in the start frame (Eq. 3.5, 3.8, 3.9; its Fig. 3.6 compares the two).
    box_share : float
        Rows and columns belong to the subject's box where their summed cost exceeds so many
        times its mean, and pixels inside the box where their cost does (Fig. 3.4; the thesis
        gives no threshold).
    sd_floor_grey : float
        Least standard deviation of a background pixel, grey values: of a few empty frames some
        pixels show no change at all.
    limit_stiffness : float
        Cost of a joint beyond its range, in sigma per squared degree (ranges are soft at their
        ends: two legs of the thesis go beyond them). 0: no ranges.
    leg_lengths : {"fitted", "start"}
        Whether each leg is made as long as it looks in the start frame, where raised legs look
        short, or keeps its length in the start pose (the thesis: one leg span, adjusted by eye).
        Either way lengths stay the same throughout.
    first_multiplier : int
        Angle steps start with so many degrees and end with one ("generally 5").
    combinations : int
        Random combinations of -1, 0 and 1 that are tried for each limb and multiplier, shared
        between those that turn the first joint, those that turn the second but not the first,
        and so on. The thesis gives no number.
    max_rounds : int
        Most rounds of position, angles and min-cut in a frame; fewer where the energy is no
        longer lowered.
    seed : int
        Seed of the random combinations; every frame has its own stream, so that a frame's
        result does not depend on how many were tracked before it.
    """

    ising: float | None = None
    contrast: float | None = None
    edge_grey: float | None = None
    thickness_px: float | None = None
    steepness: float | None = None
    subject: Literal["background mean", "gaussian"] = "background mean"
    box_share: float = 1.0
    sd_floor_grey: float = 1.0
    limit_stiffness: float = 1.0
    leg_lengths: Literal["fitted", "start"] = "fitted"
    first_multiplier: int = 5
    combinations: int = 20
    max_rounds: int = 15
    seed: int = 0

    def __post_init__(self) -> None:
        check_ranges(
            self,
            above_0=(
                "edge_grey", "thickness_px", "steepness", "box_share", "sd_floor_grey",
                "first_multiplier", "combinations", "max_rounds",
            ),
            least_0=("ising", "contrast", "limit_stiffness", "seed"),
        )  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class EnergyParameters:
    """The parameters of the energy, as set or as estimated from the start frame (Table 3.3).

    Parameters
    ----------
    sigma : float
        Standard deviation of the background's cost over the start frame.
    ising : float
        K of Eq. 3.10.
    contrast : float
        lambda of Eq. 3.11.
    edge_grey : float
        sigma of Eq. 3.11.
    thickness_px : float
        d_r of Eq. 3.15, px.
    steepness : float
        mu of Eq. 3.15, cost per px.
    subject_mean, subject_sd : float
        Mean and standard deviation of the subject's grey values in the start frame (Eq. 3.8,
        3.9).
    subject_box : tuple of int
        Box of the subject in the start frame (Fig. 3.4c): u0, v0, u1, v1, half open.
    """

    sigma: float
    ising: float
    contrast: float
    edge_grey: float
    thickness_px: float
    steepness: float
    subject_mean: float
    subject_sd: float
    subject_box: tuple[int, int, int, int]


def fill_parameters(
    settings: Pullar2009Settings,
    animal: StickAnimal,
    *,
    scale: float,
    sigma: float,
    subject: tuple[float, float, tuple[int, int, int, int]],
) -> EnergyParameters:
    """Return the parameters of the energy: those that are set, the others as in Table 3.3.

    Parameters
    ----------
    settings : Pullar2009Settings
        What was set.
    animal : StickAnimal
        Its leg span sets the thickness.
    scale : float
        px per unit of the animal's lengths.
    sigma : float
        Standard deviation of the background's cost over the start frame.
    subject : tuple
        Mean, standard deviation and box of the subject in the start frame.

    Returns
    -------
    EnergyParameters
        All parameters.

    Notes
    -----
    Table 3.3 prints "sigma / d_r" for mu with the word sigma spelled out; it is the same sigma
    as in its other rows, so that a subject pixel two d_r away from the stick costs sigma.
    """

    def given(value: float | None, default: float) -> float:
        return default if value is None else value

    thickness = given(settings.thickness_px, animal.span * scale * PULLAR2009.thickness_of_span)
    mean, sd, box = subject
    return EnergyParameters(
        sigma=sigma,
        ising=given(settings.ising, PULLAR2009.ising_of_sigma * sigma),
        contrast=given(settings.contrast, PULLAR2009.contrast_of_sigma * sigma),
        edge_grey=given(settings.edge_grey, sigma),
        thickness_px=thickness,
        steepness=given(settings.steepness, sigma / thickness),
        subject_mean=mean,
        subject_sd=sd,
        subject_box=box,
    )
