"""Parameters of the stage ``data_association``, each with unit and evidence."""

from __future__ import annotations

from dataclasses import dataclass

from pawnb.core.parameters import in_force


@dataclass(frozen=True)
class DataAssociationParameters:
    """How clicks, views, points and tracklets are joined, beside ``association`` and ``identity``.

    Parameters
    ----------
    click_sd : float
        Standard deviation of a click, in places of the grid. Set by hand.
    epipolar_modes : int
        Places of a view, the likeliest, whose lines are laid in the other. Set by hand.
    epipolar_floor : float
        What a place far from every line keeps: the other view may be wrong. Set by hand.
    epipolar_sd_radii : float
        Standard deviation of a line, in radii: two clicks of one paw in two views are so far apart.
        Set by hand.
    compare_blur : float
        Blur before two distributions are compared, in places of the grid: about half a paw. Set by
        hand.
    click_worth : float
        What a tracklet through a click is worth to the point that was clicked, natural logarithm.
        Set by hand.
    start_sd_radii : float
        Standard deviation, in radii, of where a tracklet goes on, as things that meet hide each
        other. Set by hand.
    velocity_sd_radii : float
        That of its velocity, in radii a row. Set by hand.
    drift_sd_radii : float
        That of how far it strays from a constant velocity in each row, at least. Set by hand.
    most_nodes : int
        The solver stops after so many nodes. Set by hand.
    solver_gap : float
        Or when nothing better than by this share is possible. Set by hand.
    most_continuations : int
        Tracklets that are tried as the continuation of one. Set by hand.
    overlap_rows : int
        Rows by which a tracklet may begin before the one that it continues has ended. Set by hand.
    ahead_rows : int
        Rows over which predictions at constant velocity are compared with what came. Set by hand.
    names_unsure : float
        Added to probabilities by appearance before names are compared. Set by hand.
    most_there : float
        What appearance and prior can say at most for or against there being any point at all,
        natural logarithm. Set by hand.
    decided_sd : float
        Standard deviation of a place that was decided on, in places of the grid. Set by hand.
    prior_sd : float
        Standard deviation about a click, in extents: a paw swings over about half of one. Set by
        hand.
    prior_least_radii : float
        The same in radii, at least. Set by hand.
    velocity_rows : int
        Rows from which the velocity at either end of a tracklet is found. Set by hand.
    mode_blur : float
        Blur before the likeliest place is taken, in places of the grid. Set by hand.
    least_mode : float
        Places about which less of the probability lies are not taken. Set by hand.
    taken_radii : float
        Side, in radii, of the square about a place whose probability takes it from others. Set by
        hand.
    there_unsure : float
        The probability that there is any point is at least this, and at most one less this. Set by
        hand.
    closed_radii : float
        Radius, in radii, of what is closed about a place that was decided on. Set by hand.
    to_come_even : float
        Share, in probabilities of being lost, by which what is to come is even. Set by hand.
    prior_narrower : tuple of float
        Factors of the standard deviation about clicks: of one, of two or three, of more. Set by
        hand.
    prior_blur_radii : float
        Blur, in radii, of where a point was before it is a prior. Set by hand.
    prior_even : float
        Share of such a prior that is even. Set by hand.
    beside_radii : float
        A tracklet is cut where another begins or ends so near to it, in radii. Set by hand, half as
        far again as candidates are from each other.
    peak_blur : float
        Blur, in places of the grid, before peaks are taken. Set by hand.
    met_radii : float
        Two things meet where the second is farther than the first by less than so many radii. Set
        by hand.
    """

    click_sd: float = 0.6
    epipolar_modes: int = 3
    epipolar_floor: float = 0.05
    epipolar_sd_radii: float = 0.5
    compare_blur: float = 1.5
    click_worth: float = 100.0
    start_sd_radii: float = 1.0
    velocity_sd_radii: float = 0.2
    drift_sd_radii: float = 0.05
    most_nodes: int = 200
    solver_gap: float = 1e-4
    most_continuations: int = 8
    overlap_rows: int = 3
    ahead_rows: int = 4
    names_unsure: float = 0.02
    most_there: float = 2.0
    decided_sd: float = 1.3
    prior_sd: float = 0.22
    prior_least_radii: float = 3.2
    velocity_rows: int = 5
    mode_blur: float = 1.2
    least_mode: float = 0.02
    taken_radii: float = 1.8
    there_unsure: float = 0.01
    closed_radii: float = 0.9
    to_come_even: float = 10.0
    prior_narrower: tuple[float, ...] = (1.0, 0.8, 0.65)
    prior_blur_radii: float = 1.2
    prior_even: float = 0.15
    beside_radii: float = 2.25
    peak_blur: float = 0.8
    met_radii: float = 0.75


LINKS = in_force("data_association", DataAssociationParameters())
"""The values in force; see :func:`pawnb.core.parameters.in_force`."""
