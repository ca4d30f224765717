"""Where points usually are: what association by network flow expects before it sees a detection.

Comes in: positions of points that are known, and how the views stand. Goes out: what a position
costs for each point, relative to the body and the other points (``positional_prior``), and how far
to the side of it (``lateral_prior``).
"""
