"""Learning from the recording itself: frames in which independent kinds of evidence agree.

Comes in: detections and estimates of a first round, and clicks. Goes out: examples for the
classifier (``learning``), how far each kind of evidence is trusted (``agreement``, ``weighing``),
and what is kept for a later round (``learnt``). Self-training (Yarowsky 1995).
"""
