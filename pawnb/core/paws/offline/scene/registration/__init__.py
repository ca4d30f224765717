"""Registration of a view to the animal: the body's frame in every picture.

Comes in: the frames of a view and its clicks. Goes out: where the animal is in each and how it is
turned (``body_frame``). The camera's own motion is the similarity of most corner features (RANSAC,
Fischler and Bolles 1981); the animal is what differs from the temporal median of the scene.
"""
