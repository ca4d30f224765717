"""What a person can do with a stick animal: mouse and keys in words, and the buttons."""

from __future__ import annotations

from typing import Any

from pawnb.widgets.stick_session import StickSession

HANDLES = (
    ("Drag the disc", "move the body"),
    (
        "Drag a square",
        "in front: turn the body; on the far side: make the animal larger or smaller",
    ),
    (
        "Drag a dot",
        "bend the leg there; what is further out follows, and the joint's range is shown",
    ),
    ("Drag a tip", "the whole leg follows; with Ctrl only its last joint turns"),
)
KEYS = (
    *HANDLES,
    ("[, ]", "the chosen leg 2 % shorter, longer"),
    ("M, Delete", "the chosen leg is missing, or there after all"),
    ("Shift+N", "the chosen leg back to its natural orientation"),
    ("Shift+L, Shift+R", "copy the left legs to the right side, the right ones to the left"),
    ("P; A, Enter", "propose a pose; accept it as it is"),
    ("T", "fit the pose to the picture, as tracking with the default method begins"),
    ("C", "scale: click the two ends of a known length"),
    ("F", "the pose belongs to this frame"),
    ("Shift+F, Shift+Delete", "tracking starts from this frame as well, or not"),
    ("Ctrl+Z, Ctrl+Y", "undo, redo"),
    ("Show", "what the default and the published method make of the picture, with their settings"),
)


def stick_actions(session: StickSession) -> list[dict[str, Any]]:
    """Return the buttons that change a pose, and their keys.

    Parameters
    ----------
    session : StickSession
        The pose.

    Returns
    -------
    list of dict
        id, text, keys, title, enabled; see ``static/frame_canvas.js``.
    """
    leg = session.leg
    lost = session.pose.legs[leg].missing
    actions: list[dict[str, Any]] = [
        {"id": "propose", "text": "Propose", "keys": ["p"],
         "title": "Find the animal by its outline and lay the stick animal on it (P)"},
        {"id": "fit", "text": "Fit", "keys": ["t"],
         "title": "Fit the pose to the picture, as tracking begins (T)"},
        {"id": "scale", "text": "Scale", "keys": ["c"],
         "title": "Measure px per unit by two clicks a known length apart (C)"},
        {"id": "from_left", "text": "Mirror left → right", "keys": ["Shift+L"],
         "title": "Bend the right legs like the left ones (Shift+L)"},
        {"id": "from_right", "text": "Mirror right → left", "keys": ["Shift+R"],
         "title": "Bend the left legs like the right ones (Shift+R)"},
        {"id": "missing", "text": f"{leg} is there" if lost else f"{leg} is missing",
         "keys": ["m"], "title": "The animal has lost the chosen leg, or has it after all (M)"},
        {"id": "natural", "text": f"Straighten {leg}", "keys": ["Shift+N"],
         "title": "Put the chosen leg at its natural orientation (Shift+N)"},
        {"id": "undo", "text": "Undo", "keys": ["Ctrl+z"], "enabled": session.can_undo,
         "title": "Take back the last change (Ctrl+Z)"},
        {"id": "redo", "text": "Redo", "keys": ["Ctrl+y", "Ctrl+Shift+Z"],
         "enabled": session.can_redo, "title": "Make it again (Ctrl+Y)"},
        {"id": "shorter", "text": "Shorter", "keys": ["["], "title": f"{leg} 2 % shorter ([)"},
        {"id": "longer", "text": "Longer", "keys": ["]"], "title": f"{leg} 2 % longer (])"},
    ]  # fmt: skip
    if session.frame != session.pose_frame:
        actions[:0] = [
            {"id": "here", "text": "Pose this frame", "keys": ["f"],
             "title": "The pose belongs to the frame looked at (F)"},
            {"id": "here_too", "text": "This frame, too", "keys": ["Shift+F"],
             "title": "Tracking starts from this frame as well: give it a pose (Shift+F)"},
        ]  # fmt: skip
    elif session.proposed:
        accept = {"id": "accept", "text": "Accept", "keys": ["a", "Enter"],
                  "title": "Take the proposed pose as it is (A, Enter)"}  # fmt: skip
        actions.insert(0, accept)
    elif len(session.posed_frames) > 1:
        drop = {"id": "drop", "text": "Not this frame", "keys": ["Shift+Delete"],
                "title": "Do not start from this frame (Shift+Delete)"}  # fmt: skip
        actions.insert(0, drop)
    return actions
