"""The pose of a jointed animal, seen by one camera: stick animal, segmentation, pose inference.

After Pullar 2009 (chapter 3), at full resolution; the method ``pawnb`` goes beyond it.
"""
