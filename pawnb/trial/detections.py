"""Files that ``[tracking]`` names as evidence, and which of them belong to which views."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from pawnb.errors import InputError, did_you_mean
from pawnb.schema import shown

FIELDS = ("detections", "detections_points", "point_tracker")
"""What ``[tracking]`` names as evidence, beside settings of the tracker: other programs'
predictions, and the weights of a network that follows points."""

_EXAMPLE = '["cam1DLC.h5"], one file a view, or { cam1 = "cam1DLC.h5" }'


def read_detections(given: Any, views: Sequence[str]) -> dict[str, str]:
    """Return the file of each view that has one.

    Parameters
    ----------
    given : object
        What the trial says: files in the order of the views with "" where there is none, a
        table from views to files, or one file where there is one view.
    views : sequence of str
        Names of the views.

    Returns
    -------
    dict
        View to file.

    Raises
    ------
    InputError
        If it is something else, there are more or fewer files than views, or a view is unknown.
    """
    what = "[tracking] detections"
    if isinstance(given, str):
        given = [given]
    values = list(given.values()) if isinstance(given, Mapping) else given
    if not isinstance(values, list | tuple) or not all(isinstance(v, str) for v in values):
        raise InputError(f"{what} is {shown(given)}; expected {_EXAMPLE}.")
    if isinstance(given, Mapping):
        check_detections(given, views)
        return {view: file for view, file in given.items() if file}
    if len(values) != len(views):
        raise InputError(
            f"{what} has {len(values)} file{'s' * (len(values) != 1)} and the trial has "
            f'{len(views)} view{"s" * (len(views) != 1)}; expected one a view, in their order, "" '
            f"for a view without."
        )
    return {view: file for view, file in zip(views, values, strict=True) if file}


def check_detections(detections: Mapping[str, str], views: Sequence[str]) -> None:
    """Raise InputError if a file is given for a view that is not there."""
    for name in detections:
        if name not in views:
            raise InputError(
                f"[tracking] detections: there is no view {name!r}{did_you_mean(name, views)}; "
                f"the views are {', '.join(views)}."
            )


def read_detections_points(given: Any) -> dict[str, str]:
    """Return names of points in those files to names in the trial.

    Parameters
    ----------
    given : object
        What the trial says: a table such as ``paw_FR = "FR"``.

    Returns
    -------
    dict
        Name in the file to point of the trial.

    Raises
    ------
    InputError
        If it is something else, or two names stand for one point.
    """
    what = "[tracking.detections_points]"
    if not isinstance(given, Mapping) or not all(isinstance(v, str) for v in given.values()):
        raise InputError(f'{what} is {shown(given)}; expected lines as paw_FR = "FR".')
    points = list(given.values())
    twice = next((point for i, point in enumerate(points) if point in points[:i]), None)
    if twice is not None:
        first, second, *_ = (name for name, point in given.items() if point == twice)
        raise InputError(f"{what}: {first!r} and {second!r} are both {twice!r}; keep one of them.")
    return dict(given)


def read_point_tracker(given: Any) -> str | None:
    """Return the file with the weights of a network that follows points, if one is named.

    Parameters
    ----------
    given : object
        What the trial says.

    Returns
    -------
    str or None
        The file.

    Raises
    ------
    InputError
        If it is something else.
    """
    if given is not None and not isinstance(given, str):
        raise InputError(
            f"[tracking] point_tracker is {shown(given)}; expected the file of the weights, such "
            'as "bootstapir_checkpoint_v2.pt".'
        )
    return given or None
