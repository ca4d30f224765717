"""Spread that a few wild values do not move."""

MAD_TO_SD = 1.4826
"""Standard deviation of a Gaussian in its median absolute deviations: 1 over the 75 % quantile."""
