"""The published system for jointed animals: Pullar 2009, method ``paper``.

Comes in: a pose in one frame and the empty scene. Goes out: a pose in every frame, frame by frame
both ways. Segmentation and pose minimise one energy in turn: likelihood, Ising, contrast and a
shape prior (PoseCut; Bray, Kohli and Torr 2006), by an exact graph cut and by descent.
"""
