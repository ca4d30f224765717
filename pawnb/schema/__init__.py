"""What travels between the parts of pawnb: Tracks, the gait tables, and settings.

``Tracks`` is an :class:`xarray.Dataset`; whoever knows movement knows it.
"""

from pawnb.schema.columns import (
    DROPPED_COLUMNS,
    EVENTS_COLUMNS,
    PHASE_SUMMARY_COLUMNS,
    PHASES_COLUMNS,
    POINTS3D_COLUMNS,
    START_COLUMNS,
    STRIDES_COLUMNS,
    SUSPECTS_COLUMNS,
    TRACKS_COLUMNS,
    check_columns,
)
from pawnb.schema.settings import SettingsT, build_settings, check_ranges
from pawnb.schema.tracks import (
    ORIGIN_CODE,
    ORIGINS,
    Tracks,
    add_provenance,
    check_tracks,
    make_tracks,
)

__all__ = [
    "DROPPED_COLUMNS",
    "EVENTS_COLUMNS",
    "ORIGINS",
    "ORIGIN_CODE",
    "PHASES_COLUMNS",
    "PHASE_SUMMARY_COLUMNS",
    "POINTS3D_COLUMNS",
    "START_COLUMNS",
    "STRIDES_COLUMNS",
    "SUSPECTS_COLUMNS",
    "TRACKS_COLUMNS",
    "SettingsT",
    "Tracks",
    "add_provenance",
    "build_settings",
    "check_columns",
    "check_ranges",
    "check_tracks",
    "make_tracks",
]
