"""The stick animal as the page draws and drags it."""

from __future__ import annotations

from typing import Any

import numpy as np

from pawnb.widgets.stick_pose import StickPose
from pawnb.widgets.stick_session import StickSession


def _span_at(session: StickSession) -> float:
    """Return where the handle of the span lies, degrees from the heading: inside the picture."""
    width, height = session.size
    radius = session.species.span / 2
    for aside in (180.0, 90.0, -90.0, 0.0, 135.0, -135.0, 45.0, -45.0):
        turn = np.radians(aside)
        u, v = session.pose.on_body(radius * np.cos(turn), radius * np.sin(turn))
        if 6 < u < width - 6 and 6 < v < height - 6:
            return aside
    return 180.0


def describe(session: StickSession, pose: StickPose | None = None) -> dict[str, Any]:
    """Return the stick animal as ``static/stick.js`` draws and drags it: plain JSON.

    Parameters
    ----------
    session : StickSession
        The session.
    pose : StickPose, optional
        The pose; default that of the session.

    Returns
    -------
    dict
        xy, heading (degrees), scale, span, body (ellipses) and legs: attach, lengths (units,
        as in the picture), angles, natural, half (of the range), free, joints.
    """
    pose = session.pose if pose is None else pose
    legs = []
    for leg in session.species.legs:
        bent = pose.legs[leg.name]
        legs.append(
            {
                "name": leg.name,
                "side": leg.side,
                "colour": session.colours[leg.name],
                "attach": list(leg.attach),
                "lengths": np.round(pose.steps_px(leg.name) / pose.scale, 6).tolist(),
                "angles": np.round(bent.angles_deg, 5).tolist(),
                "natural": list(leg.natural_deg),
                "half": [whole / 2 for whole in leg.range_deg],
                "free": list(leg.free),
                "joints": list(leg.joints),
                "missing": bent.missing,
            }
        )
    body = [
        {"centre": list(part.centre), "length": part.length, "width": part.width}
        for part in session.species.body
    ]
    return {
        "xy": list(pose.xy),
        "heading": pose.heading_deg,
        "scale": pose.scale,
        "span": session.species.span,
        "span_at": _span_at(session),
        "front": max(part.centre[0] + part.length / 2 for part in session.species.body),
        "body": body,
        "legs": legs,
        "leg": session.leg,
        "dashed": session.proposed,
    }
