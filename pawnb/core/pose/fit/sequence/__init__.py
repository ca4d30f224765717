"""From frame to frame: the first frame, both directions, and the last fit of every frame.

Comes in: a fitter and known poses. Goes out: poses of all frames with their uncertainty. Messages
from the frames before and after (forward and backward) are priors of the last fit.
"""
