"""Views as stacks of pictures in the body's frame, and the optical flow within them.

Comes in: the frames of a view and its clicks. Goes out: a BodyStack. The camera's own motion is
that of most corner features (RANSAC), the animal what differs from the temporal median; its frame
(``registration``) follows centroid and orientation where that makes the pictures more alike.
"""
