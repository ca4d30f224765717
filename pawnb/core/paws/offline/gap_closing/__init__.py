"""Gap closing: what a point did where no tracklet is certain.

Comes in: observations, and certain positions on both sides of a gap. Goes out: a position for each
frame of the gap, with its covariance. Multiple hypothesis tracking (Reid 1979): hypotheses are
predicted by stance or swing, gated, updated with detections or a miss, merged and pruned;
``clutter`` models false detections, ``rejection`` reopens what was wrong.
"""
