"""A first pose without a click.

Comes in: a few frames and the empty scene. Goes out: a pose, or why there is none. The outline is
split into body and limbs, traced from their tips; the body's ellipses are fitted both ways round
and limbs are assigned to legs at least cost.
"""
