"""Joints in space from two calibrated views of a jointed animal (Pullar 2009, Eq. 5.1)."""
