"""Which place is which point, over all frames, points and views at once.

Comes in: ratios of likelihoods. Goes out: the probability of every place for every point and
frame. Forward-backward algorithm of a hidden Markov model whose prediction is carried by optical
flow (Rabiner 1989); points exclude each other, and views of a calibrated rig support each other
along epipolar lines, by mean-field iterations (Koller & Friedman 2009, chapter 11.5).
"""
