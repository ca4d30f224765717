"""Data association by network flow: which tracklets belong to which point.

Comes in: observations of all frames. Goes out: for each point and frame a position, or none where
it is occluded. Detections of two views are triangulated, those that follow each other without
ambiguity make tracklets (Huang et al. 2008), and a min-cost flow over the recording assigns
tracklets to points, occlusions included (Zhang, Li and Nevatia 2008).
"""
