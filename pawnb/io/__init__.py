"""Tracks in and out: our own files and other programs', one file each.

Readers return Tracks, or what their name says. :func:`read_any_tracks` recognises the format by
what is in the file. Names are imported when they are first used.

Examples of functions go on from here: two synthetic mice, written as DeepLabCut writes them.

>>> from pathlib import Path
>>> import numpy as np
>>> import pandas as pd
>>> import pawnb
>>> files = pawnb.synthetic.write_deeplabcut_sample("sample", animals=2)
>>> tracks = pawnb.io.read_any_tracks(files[0], fps=200.0)

and two points in space, and two cameras:

>>> space = pawnb.schema.make_tracks(range(3), ["FR", "HR"], fps=250.0, unit="mm")
>>> space["position"][:] = 1.5
>>> matrix = np.array([[800.0, 0.0, 320.0], [0.0, 800.0, 240.0], [0.0, 0.0, 1.0]])
>>> cameras = [
...     pawnb.io.Camera(name=name, matrix=matrix, distortion=(0.1, 0.0, 0.0, 0.0, 0.0),
...                     rotation=np.eye(3), translation=np.array([x, 0.0, 500.0]))
...     for name, x in (("cam1", -20.0), ("cam2", 20.0))
... ]
"""

from pawnb import _lazy

_HOME = {
    "Board": "pawnb.io.boards",
    "Camera": "pawnb.io.cameras",
    "coefs_of_cameras": "pawnb.io.cameras",
    "from_movement": "pawnb.io.movement",
    "points3d_table": "pawnb.io.native",
    "read_anipose": "pawnb.io.anipose",
    "read_any_tracks": "pawnb.io.formats",
    "read_argus_points": "pawnb.io.argus",
    "read_argus_points3d": "pawnb.io.argus",
    "read_belt_speed": "pawnb.io.belt",
    "read_board": "pawnb.io.boards",
    "read_c3d": "pawnb.io.c3d_file",
    "read_cameras": "pawnb.io.cameras",
    "read_coefs": "pawnb.io.coefs",
    "read_collected": "pawnb.io.deeplabcut",
    "read_deeplabcut": "pawnb.io.deeplabcut",
    "read_dltdv_points": "pawnb.io.dltdv",
    "read_dltdv_points3d": "pawnb.io.dltdv",
    "read_kinovea": "pawnb.io.kinovea",
    "read_locomouse": "pawnb.io.locomouse",
    "read_manual_tracking": "pawnb.io.imagej",
    "read_mtrackj": "pawnb.io.imagej",
    "read_nwb": "pawnb.io.nwb",
    "read_osp_tracker": "pawnb.io.osp_tracker",
    "read_points3d_table": "pawnb.io.track_tables",
    "read_qtm": "pawnb.io.motion_capture",
    "read_sleap": "pawnb.io.sleap",
    "read_start": "pawnb.io.start",
    "read_trackmate": "pawnb.io.trackmate",
    "read_tracks": "pawnb.io.native",
    "read_tracks_table": "pawnb.io.track_tables",
    "read_trc": "pawnb.io.motion_capture",
    "read_vicon": "pawnb.io.motion_capture",
    "read_wide_table": "pawnb.io.wide",
    "recognise_format": "pawnb.io.formats",
    "to_movement": "pawnb.io.movement",
    "tracks_table": "pawnb.io.native",
    "write_anipose": "pawnb.io.anipose",
    "write_any_tracks": "pawnb.io.formats",
    "write_argus_points": "pawnb.io.argus",
    "write_argus_points3d": "pawnb.io.argus",
    "write_authors_trial": "pawnb.io.authors2019_out",
    "write_c3d": "pawnb.io.c3d_file",
    "write_cameras": "pawnb.io.cameras_out",
    "write_coefs": "pawnb.io.coefs",
    "write_collected": "pawnb.io.deeplabcut_out",
    "write_deeplabcut": "pawnb.io.deeplabcut_out",
    "write_dltdv_points": "pawnb.io.dltdv_out",
    "write_dltdv_points3d": "pawnb.io.dltdv_out",
    "write_lenses": "pawnb.io.cameras_out",
    "write_lightning_pose": "pawnb.io.deeplabcut_out",
    "write_locomouse": "pawnb.io.locomouse_out",
    "write_mayacam": "pawnb.io.cameras_out",
    "write_movement": "pawnb.io.movement",
    "write_nwb": "pawnb.io.nwb",
    "write_opencv_cameras": "pawnb.io.cameras_out",
    "write_sleap": "pawnb.io.sleap_out",
    "write_start": "pawnb.io.start",
    "write_tracks": "pawnb.io.native",
    "write_xmalab_points": "pawnb.io.xmalab_out",
    "write_xmalab_points3d": "pawnb.io.xmalab_out",
}

__all__ = [*_HOME]

__getattr__, __dir__ = _lazy(__name__, __all__, _HOME)
