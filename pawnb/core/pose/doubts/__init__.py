"""What speaks against a whole pose track, however well each leg lies on something dark.

Comes in: the animal's outline in a few frames, and its poses. Goes out: how much of what looks
like limbs lies on no leg, and whether it goes to its rear; the verdict says both.
"""
