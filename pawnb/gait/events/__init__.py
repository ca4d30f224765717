"""Events of the feet: found, scored by hand, cleaned and corrected.

Comes in: paths of feet, or what was scored by hand. Goes out: touch-downs and lift-offs. Extreme
positions of a foot are here itself (from ``extremes``). ``event_pipeline`` has the steps in their
order; ``ground_contact`` finds touch-down and lift-off, ``debounce`` takes out what is too short,
``contacts`` and ``manual_events`` take what was scored by hand or by force plates, ``event_edits``
replays corrections, ``event_settings`` holds the settings.
"""

from pawnb import _lazy
from pawnb.gait.events.extremes import (
    Extreme,
    Rejected,
    find_extremes,
    stance_velocity,
    stance_velocity_over_time,
)

__all__ = [
    "Extreme",
    "Rejected",
    "contacts",
    "debounce",
    "event_edit_records",
    "event_edits",
    "event_pipeline",
    "event_settings",
    "find_extremes",
    "ground_contact",
    "manual_events",
    "stance_velocity",
    "stance_velocity_over_time",
]

__getattr__, __dir__ = _lazy(__name__, __all__)
