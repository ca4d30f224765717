"""Kinds of evidence: where each point may be in each frame, and how likely.

Comes in: a BodyStack and what was placed by hand. Goes out: for each point, ratios of
likelihoods over places, or Detections with log-odds that are painted into such maps. Motion is
optical flow from the clicks (Lucas & Kanade 1981; Kalal et al. 2010 for the check); appearance
is a classifier learnt in the recording.
"""
