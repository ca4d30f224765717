"""The published system for paws: Haji Maghsoudi et al. 2019, methods ``paper`` and ``slic-...``.

Comes in: annotations of one frame or two. Goes out: Tracks, frame by frame from there on.
Detection: features of superpixels (SLIC; Achanta et al. 2012) fused into one score. Prediction:
a Kalman filter in space. Occlusions: a template of the stride predicts through collisions.
"""
