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
from pawnb.schema.frames import (
    MOST_FRAMES,
    absent_frames,
    check_frames,
    every_frame,
    note_absent,
    rows_with_places,
)
from pawnb.schema.settings import (
    SettingsT,
    build_settings,
    check_fields,
    check_ranges,
    each_of,
    shown,
)
from pawnb.schema.tracks import (
    ORIGIN_CODE,
    ORIGINS,
    Tracks,
    add_provenance,
    check_fps,
    check_tracks,
    make_tracks,
)

__all__ = [
    "DROPPED_COLUMNS",
    "EVENTS_COLUMNS",
    "MOST_FRAMES",
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
    "absent_frames",
    "add_provenance",
    "build_settings",
    "check_columns",
    "check_fields",
    "check_fps",
    "check_frames",
    "check_ranges",
    "check_tracks",
    "each_of",
    "every_frame",
    "make_tracks",
    "note_absent",
    "rows_with_places",
    "shown",
]


def __dir__() -> list[str]:
    """List the public names."""
    return sorted(__all__)
