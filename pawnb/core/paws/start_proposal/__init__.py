"""The first annotations without a click.

Comes in: a few frames of every view. Goes out: a frame, and for each paw a position in each view
and how sure it is. Blobs of likely colour (top-hat filter) are paired over the views by epipolar
geometry; one combination of points in space is chosen for each frame by its likelihood.
"""
