"""Points through a whole recording of any kind, from one clicked frame or more.

Comes in: opened views, clicks, what is asked for. Goes out: Tracks. Every view becomes a stack
of pictures in the body's frame (``scene``); kinds of evidence say where each point may be
(``detection``); a hidden Markov model for each point, with exclusivity between points and
epipolar geometry between views, decides over all frames (``association``; Rabiner 1989).
"""
