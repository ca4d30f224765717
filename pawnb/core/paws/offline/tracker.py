"""Tracking points through a recording of any kind: from clicks to Tracks."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import pandas as pd

from pawnb.core.paws.layout import Layout, Views, make_layout, read_start
from pawnb.core.paws.maghsoudi2019.settings import Maghsoudi2019Settings
from pawnb.core.paws.offline.again import Again, weighing_as_attributes
from pawnb.core.paws.offline.annotations import Annotations, annotations_of_view
from pawnb.core.paws.offline.detection.colour.cache import DetectionCache
from pawnb.core.paws.offline.detection.evidence import Detections, installed_evidence
from pawnb.core.paws.offline.detection.predictions import predictions_as_detections
from pawnb.core.paws.offline.kept import KeptStacks, fits
from pawnb.core.paws.offline.landmarks.tracks import choose_landmarks
from pawnb.core.paws.offline.output import write_tracks
from pawnb.core.paws.offline.parameters import OfflineParameters, parameters_in_force
from pawnb.core.paws.offline.pipeline import (
    ViewTrack,
    no_track,
    run_pipeline,
    view_track,
)
from pawnb.core.paws.offline.quality.assessment import Quality, assess
from pawnb.core.paws.offline.quality.likeness import add_likeness
from pawnb.core.paws.offline.quality.measures import QualityLimits
from pawnb.core.paws.offline.scene.stack import BodyStack, read_stacks
from pawnb.core.paws.offline.settings import OfflineSettings
from pawnb.core.paws.offline.treadmill.annotations import read_placements
from pawnb.core.paws.offline.treadmill.learnt_appearance import strides_may_tell, track_by_strides
from pawnb.core.paws.offline.treadmill.tracker import track_treadmill, warn_of_ambiguous_colour
from pawnb.core.paws.offline.view_input import ViewInput
from pawnb.core.paws.offline.weighing import Weighing, weigh
from pawnb.core.paws.offline.windows import chance_to_go_on, handed_on, take_over, windows
from pawnb.core.paws.request import TrackingRequest
from pawnb.core.pixels.grey import has_colour
from pawnb.schema import START_COLUMNS, Tracks, check_columns

COLOUR, STRIDES, LEARNT = "colour", "strides", "learnt"
"""What tracks may be found by; kept in their attribute ``evidence``."""
_POOR, _LONG = 0.82, 64
"""Tracks by colour are compared with tracks by strides where they are not good; in fewer frames,
which hold too little of a stride to tell one way from the other, where fewer labels than this share
are expected to be right."""
_SURER = 0.05
"""They give way where so many more labels are expected to be right. Of rendered films in H.264 (100
frames, seeds 31 to 33, crf 23 and 28; all looked at) strides had that in five, and 0, 0, 0, 3 and
11 of 1000 visible labels wrong, for 61, 4, 26, 0 and 8 by colour; where they had 0.02 more, 28 for
3. Scenes in colour without H.264 (the same seeds, three variants) are good by colour."""


def track_offline(
    views: Views,
    start: pd.DataFrame,
    task: TrackingRequest,
    *,
    settings: OfflineSettings,
    looked: pd.DataFrame | None = None,
    store: DetectionCache | None = None,
    stacks: KeptStacks | None = None,
    again: Again | None = None,
) -> Tracks:
    """Track points by the first way that serves, of three.

    Paws of a colour of their own are tracked by :func:`.tracker.track_treadmill`,
    which knows strides and stance. Where colour does not tell them, as in grey pictures, or its
    tracks are not good by absolute measures (:func:`.quality.assess`), calibrated views of paws
    are tracked in the same way by a look that is learnt (:func:`.strides.track_by_strides`), and
    these tracks are kept if clearly more labels are expected to be right. Where neither applies,
    or tracks failed (on the real clips on which colour does not tell paws 7 to 37 % of labels are
    expected to be right, on rendered scenes 83 % and more), :func:`track_learnt` tracks points.

    Parameters
    ----------
    views, start, task, settings, looked, store
        As for :func:`.tracker.track_treadmill`; ``settings.evidence`` may choose one
        of the three.
    stacks : KeptStacks, optional
        Evidence of earlier runs on the same recording, for what is learnt in it.
    again : Again, optional
        What is to be tracked again, for what is learnt in the recording; colour decides over all.

    Returns
    -------
    xarray.Dataset
        Tracks; the attribute ``evidence`` is ``"colour"``, ``"strides"`` or ``"learnt"``.

    Raises
    ------
    InputError
        If a click does not fit, or a point has none.
    """
    given: dict[str, Any] = {"settings": settings, "looked": looked, "store": store}
    n = task.frames[1] - task.frames[0]
    enough = QualityLimits().good if n >= _LONG else _POOR
    best: tuple[Quality, Tracks] | None = None
    for kind in _ways(views, start, task, settings=settings, looked=looked):
        find: Callable[..., Tracks] = track_treadmill if kind == COLOUR else track_by_strides
        tracks = find(views, start, task, **given)
        tracks.attrs["evidence"] = kind
        complete = tracks.sizes["time"] >= n
        if settings.evidence == kind or not complete:
            return tracks
        quality = assess(add_likeness(views, tracks, start), clicks=start)
        if best is None or quality.expected_right > best[0].expected_right + _SURER:
            best = quality, tracks
        if best[0].expected_right >= enough:
            break
    if best is not None and best[0].verdict != "failed":
        return best[1]
    tracks = track_learnt(views, start, task, looked=looked, stacks=stacks, again=again)
    tracks.attrs["evidence"] = LEARNT
    return tracks


def _ways(
    views: Views,
    start: pd.DataFrame,
    task: TrackingRequest,
    *,
    settings: OfflineSettings,
    looked: pd.DataFrame | None,
) -> list[str]:
    """Return by what tracks are sought, one after the other until one serves."""
    if settings.evidence in (COLOUR, STRIDES):
        return [settings.evidence]
    if settings.evidence == LEARNT:
        return []
    by_strides = strides_may_tell(views, start, task, settings=settings)
    # brightness alone tells a paw worse than a look that is learnt
    by_colour = not by_strides or _has_colour(views, int(start["frame"].iloc[0]))
    ways = []
    if by_colour and _colour_may_tell(views, start, task, settings, looked):
        ways.append(COLOUR)
    return [*ways, STRIDES] if by_strides else ways


def _has_colour(views: Views, frame: int) -> bool:
    """Tell whether any view is in colour."""
    pictures = views.frame(frame)
    sizes = {name: views.readers[name] for name in views.names}
    return any(
        has_colour(pictures[name].crop(0, 0, reader.width, reader.height))
        for name, reader in sizes.items()
    )


def _colour_may_tell(
    views: Views,
    start: pd.DataFrame,
    task: TrackingRequest,
    settings: OfflineSettings,
    looked: pd.DataFrame | None,
) -> bool:
    """Tell whether colour is worth trying: no predictions, and paws unlike what is about them."""
    if task.predictions or (task.rig is None and len(views.names) > 1):
        return False
    points = list(dict.fromkeys(start["point"]))
    kinds = [Maghsoudi2019Settings().kind(point) for point in points]
    if choose_landmarks(tuple(points), tuple(kinds), settings.landmarks).all():
        return False
    return (
        looked is not None
        or warn_of_ambiguous_colour(views, start, task, settings=settings) is None
    )


def track_learnt(
    views: Views,
    start: pd.DataFrame,
    task: TrackingRequest,
    *,
    parameters: OfflineParameters | None = None,
    looked: pd.DataFrame | None = None,
    stacks: KeptStacks | None = None,
    again: Again | None = None,
) -> Tracks:
    """Track points by evidence that is learnt in the recording itself.

    Parameters
    ----------
    views : Views
        The opened views; several views without a rig are tracked each by itself.
    start : DataFrame
        Clicks with columns frame, view, point, u, v (px), in any number of frames, of any
        part of the points in each.
    task : TrackingRequest
        What is to be tracked.
    parameters : OfflineParameters, optional
        Parameters of all stages.
    looked : DataFrame, optional
        Earlier clicks, columns as ``start``, by which the body's frame was found; it is the same
        again where ``start`` lies well within.
    stacks : KeptStacks, optional
        Pictures and flow of earlier runs on the same recording. What is there and fits is not
        decoded again, and what is decoded goes there.
    again : Again, optional
        Frames that are to be tracked again; all others are missing in what is returned.

    Returns
    -------
    xarray.Dataset
        Tracks, see :func:`.output.write_tracks`; without any frame where the run was stopped.

    Raises
    ------
    InputError
        If a click does not fit, or a point has none.
    CalibrationError
        If the rig lacks a view.
    """
    check_columns(start, START_COLUMNS, where="the start points")
    task.check_frames(views.n_frames)
    parameters = parameters or parameters_in_force()
    layout = make_layout(views, start, task, settings=Maghsoudi2019Settings())
    _, anchors = read_placements(start, layout, task.frames, tracks=task.tracks)
    first, n = task.frames[0], task.frames[1] - task.frames[0]
    placed = [annotations_of_view(anchors, v, first) for v in range(len(layout.views))]
    found = [no_track(n, len(layout.points)) for _ in layout.views]
    run = _Run(
        views, layout, task, parameters, placed, _framed_by(looked, layout, task) or placed,
        found, stacks or KeptStacks(most_bytes=0), again,
    )  # fmt: skip
    spans = windows(n, [row for annotations in placed for row in annotations.rows])
    spans = [span for span in spans if again is None or again.rows_in(first, span)]
    said: list[str] = []
    weighed: Weighing | None = None
    for i, span in enumerate(spans):
        tracked = run.track_window(span, advanced=_reporter(task, done=i, of=len(spans)))
        if tracked is None:  # stopped: a part of the recording does not decide over the whole
            nothing = [no_track(0, len(layout.points)) for _ in layout.views]
            return write_tracks(nothing, layout, task, placed={})
        said = said or tracked
        weighed = weighed or run.weighing
    tracks = write_tracks(
        found, layout, task, placed={frame - first: here for frame, here in anchors.items()}
    )
    tracks.attrs["body_frame"] = "; ".join(said)
    if weighed is not None:
        tracks.attrs.update(weighing_as_attributes(weighed))
    return tracks


def _framed_by(
    looked: pd.DataFrame | None, layout: Layout, task: TrackingRequest
) -> list[Annotations] | None:
    """Return the clicks by which the body's frame was found earlier."""
    if looked is None or not len(looked):
        return None
    inside = looked[looked["frame"].between(task.frames[0], task.frames[1] - 1)]
    placed = read_start(inside, layout, task.frames)
    return [annotations_of_view(placed, v, task.frames[0]) for v in range(len(layout.views))]


@dataclass
class _Run:
    """A recording that is tracked window by window.

    Attributes
    ----------
    placed, framing : sequence of Annotations
        For each view what is certain, and the clicks by which the body's frame is found.
    found : sequence of ViewTrack
        For each view, what is tracked so far.
    weighing : Weighing
        How far appearance was trusted in the last window.
    """

    views: Views
    layout: Layout
    task: TrackingRequest
    parameters: OfflineParameters
    placed: Sequence[Annotations]
    framing: Sequence[Annotations]
    found: Sequence[ViewTrack]
    stacks: KeptStacks
    again: Again | None
    weighing: Weighing | None = None

    def track_window(
        self, span: tuple[int, int], *, advanced: Callable[[int], bool]
    ) -> list[str] | None:
        """Track one window; return how its views were seen, None where stopped."""
        begin, end = span
        own, framing = (
            [
                handed_on(a, whole, begin=begin, end=end)
                for a, whole in zip(placed, self.found, strict=True)
            ]
            for placed in (self.placed, self.framing)
        )
        used = [v for v, annotations in enumerate(own) if annotations.rows]
        if not used:
            return []
        stacks = self._stacks(span, [own[v] for v in used], framing, used, advanced)
        if stacks is None:
            return None
        first, n_points, again = self.task.frames[0], len(self.layout.points), self.again
        inputs = []
        for v, stack in zip(used, stacks, strict=True):
            detections = _detections(
                self.layout, self.task, stack, annotations=own[v], view=v, span=span
            )
            one = ViewInput(self.layout.views[v], self.layout.sizes[v], stack, own[v], detections)
            if again is not None:
                known = again.known(one.name, self.layout.points, first).part(begin, end)
                one = dataclasses.replace(one, known=known)
            inputs.append(one)
        rows = None if again is None else again.rows_in(first, span)
        self.weighing = (
            weigh(inputs, n_points, self.parameters) if again is None else again.weighing
        )
        tracks = run_pipeline(
            inputs, n_points=n_points, parameters=self.parameters, rig=self.layout.rig,
            rows=rows, weighing=self.weighing,
        )  # fmt: skip
        for v, one, points in zip(used, inputs, tracks, strict=True):
            chance = chance_to_go_on(self.placed[v], self.found[v], begin=begin, end=end)
            part = one.stack if rows is None else one.stack.part(*rows)
            track = view_track(part, points, n_points, chance=chance)
            take_over(self.found[v], track, begin + (rows or (0, 0))[0])
        return [_said(one) for one in inputs]

    def _stacks(
        self,
        span: tuple[int, int],
        own: Sequence[Annotations],
        framing: Sequence[Annotations],
        used: Sequence[int],
        advanced: Callable[[int], bool],
    ) -> list[BodyStack] | None:
        """Return the pictures of the views that are used: kept ones that fit, else read."""
        first = self.task.frames[0]
        names = [self.layout.views[v] for v in used]
        asked: dict[str, Any] = {
            "frames": (first + span[0], first + span[1]), "parameters": self.parameters.scene,
        }  # fmt: skip
        kept = self.stacks.find(names, own, **asked)
        if kept is not None:
            return kept
        stacks = None
        if all(framing[v].rows for v in used):
            by_view = [a if v in used else Annotations({}) for v, a in enumerate(framing)]
            stacks = read_stacks(self.views, by_view, **asked, advanced=advanced)
            if stacks is None:
                return None
        if stacks is None or not all(map(fits, stacks, own)):
            by_view = [Annotations({})] * len(framing)
            for v, annotations in zip(used, own, strict=True):
                by_view[v] = annotations
            stacks = read_stacks(self.views, by_view, **asked, advanced=advanced)
        if stacks is not None:
            self.stacks.keep(names, stacks, **asked)
        return stacks


def _detections(
    layout: Layout,
    task: TrackingRequest,
    stack: BodyStack,
    *,
    annotations: Annotations,
    view: int,
    span: tuple[int, int],
) -> list[Detections]:
    """Return what other programs and other packages' kinds of evidence find in a view."""
    name = layout.views[view]
    found = [
        kind.detect(name, stack, annotations=annotations, points=layout.points)
        for kind in installed_evidence()
    ]
    if name in task.predictions:
        uv, likelihood = task.predictions[name].of(layout.points)
        part = slice(*span)
        found.append(
            predictions_as_detections(
                uv[part], likelihood[part], annotations, size=layout.sizes[view]
            )
        )
    return found


def _reporter(task: TrackingRequest, *, done: int, of: int) -> Callable[[int], bool]:
    """Return what tells a person how far the video is read, and asks whether to go on."""
    n = task.frames[1] - task.frames[0]

    def advanced(read: int) -> bool:
        if task.progress is not None:  # a window is read twice
            task.progress(min(n, (done * n + read * of // 2) // of), n)
        return task.stop is None or not task.stop()

    return advanced


def _said(view: ViewInput) -> str:
    """Say how the body's frame of a view was found."""
    body = view.stack.body
    how = {
        "stays": "the animal stays in place",
        "follows": "it follows the animal",
        "travels": "it follows the animal",
        "turns": "it follows the animal and turns with it",
    }[body.kind]
    return f"{view.name}: {how}" + (", the camera moves" if body.pans else "")
