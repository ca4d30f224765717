"""Events of the feet: found, scored by hand, cleaned and corrected.

``event_pipeline`` has the steps in their order; ``ground_contact`` finds touch-down and lift-off,
``debounce`` takes out what is too short, ``manual_events`` checks events scored by hand,
``event_edits`` replays corrections, ``event_settings`` holds the settings.
"""

from pawnb import _lazy

__all__ = [
    "debounce",
    "event_edit_records",
    "event_edits",
    "event_pipeline",
    "event_settings",
    "ground_contact",
    "manual_events",
]

__getattr__, __dir__ = _lazy(__name__, __all__)
