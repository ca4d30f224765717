"""How good tracks are, by measures that do not depend on the recording or the tracker.

Comes in: Tracks. Goes out: the probability that each label is right, and a verdict: good, look or
failed. ``signs`` and ``measures`` are what tells, ``likeness`` compares pictures with those at the
annotations (normalised correlation), ``calibration`` turns signs into probabilities by a logistic
model learnt on marked real clips.
"""
