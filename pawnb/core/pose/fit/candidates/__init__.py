"""Poses that single legs might have, and the choice among them over all frames.

Comes in: a fitted frame. Goes out: candidates of each leg with their costs, and the cheapest path
of each side's legs through the recording (dynamic programming; Viterbi 1967).
"""
