"""Detections of paws by their colour: tips of limbs, or blobs in a view from below.

Comes in: frames of every view, annotations. Goes out: detections of every frame and view (a cache
on disk keeps them), and how likely each is a paw, as observations of each point. The colour model
is a log-likelihood ratio of paw and background histograms (Jones and Rehg 2002), learnt from the
annotated pictures; only this pipeline for coloured paws on a treadmill uses it.
"""
