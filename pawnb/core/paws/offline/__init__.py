"""Tracking points through a whole recording, and saying how well it went.

``quality`` tells from the tracks of any method how many labels are expected to be right. Its
limits are absolute: they do not depend on what is usual in the recording.
"""
