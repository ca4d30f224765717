"""Analysis by synthesis: the animal painted, and fitted to what a frame shows.

Comes in: a frame, the background, a pose. Goes out: darkness relative to the background, the
painted picture, and the pose of least squares by damped Gauss-Newton steps (Levenberg 1944).
"""
