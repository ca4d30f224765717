"""Coloured paws of an animal on a treadmill: the pipeline that knows colour, strides and stance.

Comes in: opened views, annotations, the request. Goes out: Tracks. The stages, in order:
``detection.colour``, ``scene``, ``association.network_flow`` (min-cost flow of tracklets),
``stride``, ``gap_closing`` (multiple hypothesis tracking) and ``smoothing``; association and gap
closing are repeated until the stride model no longer changes them.
"""
