"""What is learnt in the recording: the animal's appearance, its pose prior, and clutter about it.

Comes in: frames whose pose is known. Goes out: thickness and darkness of its parts, how it holds
its legs, and what stands out from legs and body and is neither (hairs, wings, palps).
"""
