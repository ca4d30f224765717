"""Tracks of an animal that trots on a belt, made by rule: what tests of gait runs share."""

from __future__ import annotations

import numpy as np

from pawnb import schema
from pawnb.trial import Animal, Calibration, Trial
from pawnb.workflow.provenance.results import describe_trial

LEGS = ("FR", "HR", "FL", "HL")
FPS, PERIOD_S, DUTY, BELT = 250.0, 0.2, 0.6, 300.0
LAGS = {"FR": 0.0, "HL": 0.05, "FL": 0.5, "HR": 0.55}


def walking_tracks(trial: str, animal: str) -> schema.Tracks:
    """Two seconds of a trot on a belt: five strides a second, duty factor 0.6.

    In stance a foot goes back with the belt, in swing forward on a raised cosine. Diagonal
    legs step almost together (0.05 cycle apart), left and right half a cycle apart.
    """
    frames = np.arange(500)
    tracks = schema.make_tracks(frames, LEGS, fps=FPS, individual=animal, unit="mm")
    for k, leg in enumerate(LEGS):
        phase = (frames / FPS / PERIOD_S - LAGS[leg]) % 1.0
        reach = BELT * DUTY * PERIOD_S
        swing = np.clip((phase - DUTY) / (1 - DUTY), 0, 1)
        x = np.where(phase < DUTY, reach * (0.5 - phase / DUTY), -reach / 2 * np.cos(np.pi * swing))
        tracks["position"][:, 0, k, 0] = x
        tracks["position"][:, 1, k, 0] = 10.0 if leg.endswith("L") else -10.0
        tracks["position"][:, 2, k, 0] = np.where(phase < DUTY, 0, 8 * np.sin(np.pi * swing))
    tracks["origin"][:] = schema.ORIGIN_CODE["measured"]
    tracks["confidence"][:] = 1.0
    description = Trial(
        kind="tracks", name=trial, fps=FPS, animal=Animal(id=animal), belt_speed=BELT,
        calibration=Calibration(unit="mm"), tracks_file="tracks.nc",
    )  # fmt: skip
    return describe_trial(tracks, description)
