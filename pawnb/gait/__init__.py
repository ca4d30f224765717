"""Gait statistics on tracks or events from any source; this part knows no video."""

from pawnb import _submodules
from pawnb.gait.analysis import analyse, analyse_events
from pawnb.gait.body_angles import body_angles
from pawnb.gait.event_edits import replay_event_edits
from pawnb.gait.event_settings import EventSettings
from pawnb.gait.pose_body import leg_angles
from pawnb.gait.tables import GaitTables, pool

__all__ = [
    "EventSettings",
    "GaitTables",
    "analyse",
    "analyse_events",
    "body_angles",
    "leg_angles",
    "pool",
    "replay_event_edits",
]

__getattr__ = _submodules(__name__)
