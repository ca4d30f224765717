"""Clicks followed by a network that was trained elsewhere and that a trial names.

Comes in: a view as a stack of pictures, annotations, the file with the network's weights.
Goes out: detections of points in each row, believed as far as clicks say at which paths end.
"""
