"""What is read off Tracks before events: body, feet, substrate and scales of time.

Comes in: Tracks. Goes out: paths of feet and body relative to what the animal runs on.
``foot_trajectories`` takes the feet out of Tracks; ``body``, ``body_path``, ``pose_body`` and
``direction`` say where the animal is and faces; ``substrate`` what it runs on; ``time_scales`` sets
cut-offs from its stride frequency; ``grid`` makes samples equally spaced.
"""

from pawnb import _lazy

__all__ = [
    "body",
    "body_path",
    "direction",
    "foot_trajectories",
    "grid",
    "pose_body",
    "substrate",
    "time_scales",
]

__getattr__, __dir__ = _lazy(__name__, __all__)
