"""Clutter: detections of a limb that are not its paw.

Comes in: the observations of every frame, and where points are believed to be. Goes out: what a
detection costs as one of the limb (``limb_clutter``), and which detections are wrists, and where
that says the paw is (``wrist_clutter``). The clutter of multitarget tracking (Bar-Shalom and
Fortmann 1988), with a density that is learnt in the recording.
"""
