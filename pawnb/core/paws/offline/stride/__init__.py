"""The stride of an animal on a substrate that moves: a model learnt in the recording itself.

Comes in: positions of points over frames, where they are certain. Goes out: where each point is
expected at each moment of the stride (``cycle``), where it stands (``stance``), how long
(``duty_factor``), and how it swings (``swing_detection``, ``swing``, ``swing_trajectory``).
Stance and swing as in the gait literature (Hildebrand 1965); only the treadmill pipeline uses it.
"""
