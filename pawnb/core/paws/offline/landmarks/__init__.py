"""Landmarks that are no paws (nose, ears, tail, marks): followed by their own picture.

Comes in: annotations and frames. Goes out: a position in each view and frame, joined in space.
Template matching by normalised correlation, refined by the inverse compositional Lucas-Kanade
algorithm (Baker and Matthews 2004), forwards and backwards from every annotation.
"""
