"""Joints in space from two calibrated views of a jointed animal.

Comes in: poses of the first view, the second view and the calibration. Goes out: joints in space
with standard deviations. The heights of legs that the first view leaves open are those with which
the animal, painted into the second view, resembles it most (damped Gauss-Newton steps); joints of
a leg lie in a plane (Pullar 2009, Eq. 5.1).
"""
