"""The pose tracker of pawnb: a painted stick animal fitted to the picture.

Comes in: poses in one frame or more, frames, the empty scene. Goes out: poses of every frame with
standard deviations. Analysis by synthesis: ``rendering`` paints the animal and fits it by damped
Gauss-Newton steps, ``candidates`` chooses among poses of legs over the recording (Viterbi 1967),
``learning`` adapts the model to the animal, ``sequence`` leads through the frames.
"""
