"""From associated positions to smooth tracks with standard deviations.

Comes in: positions in space and the observations of every view. Goes out: positions, covariances,
which detections were used, and diagnostics. A minimum-jerk smoothing spline by banded normal
equations with robust weights; ``forward_backward_distance`` compares a filter forwards with one
backwards, ``association_odds`` the detection taken with the next best one.
"""
