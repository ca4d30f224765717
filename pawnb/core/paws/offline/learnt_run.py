"""Tracking points by evidence that is learnt in the recording itself, window by window."""

from __future__ import annotations

import dataclasses
import functools
import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd

from pawnb.core.paws.layout import Layout, Views, make_layout, read_start
from pawnb.core.paws.maghsoudi2019.settings import Maghsoudi2019Settings
from pawnb.core.paws.offline.annotations import Annotations, annotations_of_view
from pawnb.core.paws.offline.detection.evidence import installed_evidence
from pawnb.core.paws.offline.detection.others import detections_of_others
from pawnb.core.paws.offline.output import write_tracks
from pawnb.core.paws.offline.parameters import RUN, OfflineParameters, parameters_in_force
from pawnb.core.paws.offline.pipeline import ViewTrack, no_track, run_pipeline, view_track
from pawnb.core.paws.offline.reuse.kept_evidence import (
    GONE_ON_FROM,
    KeptStacks,
    RunBefore,
    fits,
    same_size,
)
from pawnb.core.paws.offline.reuse.retracking import (
    Again,
    after_clicks,
    weighing_as_attributes,
    weighing_of,
)
from pawnb.core.paws.offline.scene.extents import with_extents
from pawnb.core.paws.offline.scene.stack import BodyStack, read_stacks
from pawnb.core.paws.offline.self_training.doubted_clicks import (
    DoubtedClick,
    doubted_as_attributes,
    find_doubted_clicks,
)
from pawnb.core.paws.offline.self_training.learnt import LEARNT_IN, Learnt, learnt_as_text
from pawnb.core.paws.offline.self_training.weighing import Weighing, weigh
from pawnb.core.paws.offline.treadmill.annotations import read_placements
from pawnb.core.paws.offline.view_input import ViewInput
from pawnb.core.paws.offline.windows import (
    chance_to_go_on,
    handed_on,
    take_over,
    windows,
)
from pawnb.core.paws.request import TrackingRequest
from pawnb.core.paws.retracked_span import keep_rows
from pawnb.schema import START_COLUMNS, Tracks, check_columns


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
        Pictures and flow of the last run on the same recording; those of this one go there. If
        clicks were only added since that run, nothing is decoded, the frames up to the clicks on
        either side are tracked anew, and all others are as they were. Where its pictures do not
        show what was added, others are read and all frames are tracked anew, from what that run
        has learnt. If not, this run is one as if there had been none before; but what is tracked
        again or framed by earlier clicks takes what is there and fits.
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
    stacks = stacks or KeptStacks(most_bytes=0)
    alone = again is None and looked is None and task.tracks is None
    before = _run_before(stacks, start, layout, task=task, parameters=parameters) if alone else None
    if alone and before is None:
        stacks.forget()
    if before is not None:
        seen = _shown(stacks, start, layout, task=task, parameters=parameters)
        again = after_clicks(before.tracks, before.starts[-1], start, everywhere=not seen)
    run = _Run(
        views, layout, task, parameters, placed, _framed_by(looked, layout, task) or placed,
        [no_track(n, len(layout.points)) for _ in layout.views], stacks, again,
    )  # fmt: skip
    if not run.track_windows():  # stopped: a part of the recording does not decide over the whole
        nothing = [no_track(0, len(layout.points)) for _ in layout.views]
        return write_tracks(nothing, layout, task, placed={})
    tracks = write_tracks(
        run.found, layout, task, placed={frame - first: here for frame, here in anchors.items()}
    )
    tracks.attrs.update(run.as_attributes())
    if again is not None and before is not None:
        rows = tracks["frame"].to_numpy()
        outside = (rows < again.frames[0]) | (rows >= again.frames[1])
        keep = np.repeat(outside[:, None], len(layout.points), axis=1)
        tracks = keep_rows(before.tracks, tracks, keep)
    if alone:
        starts = () if before is None else before.starts
        own = tracks.copy(deep=True)  # the others may be corrected in place
        stacks.keep_run(RunBefore(_asked(layout, task, parameters), (*starts, start), own))
        earlier = [one.to_dict(orient="records") for one in starts]
        tracks = tracks.assign_attrs({GONE_ON_FROM: json.dumps(earlier)})
    return tracks


def goes_on(
    views: Views, start: pd.DataFrame, task: TrackingRequest, *, stacks: KeptStacks
) -> bool:
    """Tell whether clicks were only added since the last run by what is learnt.

    Parameters
    ----------
    views, start, task, stacks
        As for :func:`track_learnt`.

    Returns
    -------
    bool
        Whether what that run has learnt would be taken on.
    """
    layout = make_layout(views, start, task, settings=Maghsoudi2019Settings())
    return (
        _run_before(stacks, start, layout, task=task, parameters=parameters_in_force()) is not None
    )


def _run_before(
    stacks: KeptStacks,
    start: pd.DataFrame,
    layout: Layout,
    *,
    task: TrackingRequest,
    parameters: OfflineParameters,
) -> RunBefore | None:
    """Return the last run, if clicks were only added since, to an animal of the same size."""
    before = stacks.run_before(_asked(layout, task, parameters))
    if before is None or task.frames[1] - task.frames[0] > RUN.window_rows:
        return None
    if after_clicks(before.tracks, before.starts[-1], start) is None:
        return None
    old, new = (_placed(clicks, layout, task) for clicks in (before.starts[-1], start))
    return before if same_size(old, new) else None


def _shown(
    stacks: KeptStacks,
    start: pd.DataFrame,
    layout: Layout,
    *,
    task: TrackingRequest,
    parameters: OfflineParameters,
) -> bool:
    """Tell whether the pictures that are kept show all that was placed."""
    own = _placed(start, layout, task)
    used = [v for v, annotations in enumerate(own) if annotations.rows]
    kept = stacks.find(
        [layout.views[v] for v in used], [own[v] for v in used],
        frames=task.frames, parameters=parameters.scene,
    )  # fmt: skip
    return kept is not None


def _placed(start: pd.DataFrame, layout: Layout, task: TrackingRequest) -> list[Annotations]:
    """Return what clicks place in each view, with the extent of the animal."""
    placed = read_start(start, layout, task.frames)
    own = [annotations_of_view(placed, v, task.frames[0]) for v in range(len(layout.views))]
    return with_extents(own, layout.sizes, layout.rig)


def _asked(layout: Layout, task: TrackingRequest, parameters: OfflineParameters) -> str:
    """Return what must be the same, beside the clicks, for a run to go on from another."""
    rig = None if layout.rig is None else layout.rig.coefs.tolist()
    known = {view: [a.tobytes().hex() for a in p.of(layout.points)]
             for view, p in task.predictions.items()}  # fmt: skip
    kinds = [kind.name for kind in task.evidence]
    said = [
        task.frames, layout.views, layout.points, layout.sizes, rig, known, kinds, repr(parameters)
    ]  # fmt: skip
    return hashlib.sha256(json.dumps(said).encode()).hexdigest()


def _framed_by(
    looked: pd.DataFrame | None, layout: Layout, task: TrackingRequest
) -> list[Annotations] | None:
    """Return the clicks by which the body's frame was found earlier."""
    if looked is None or not len(looked):
        return None
    inside = looked[looked["frame"].between(task.frames[0], task.frames[1] - 1)]
    return _placed(inside, layout, task)


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
        How far kinds were trusted in the first window.
    learnt : dict
        View to what was learnt of it so far.
    doubted : list of DoubtedClick
        Clicks that others contradict.
    said : list of str
        How the body's frame was found in each view.
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
    learnt: dict[str, Learnt] = field(default_factory=dict)
    doubted: list[DoubtedClick] = field(default_factory=list)
    said: list[str] = field(default_factory=list)

    @functools.cached_property
    def _asked(self) -> str:
        return _asked(self.layout, self.task, self.parameters)

    def track_windows(self) -> bool:
        """Track all windows that are asked for; tell whether that was done to the end."""
        first, n = self.task.frames[0], self.task.frames[1] - self.task.frames[0]
        spans = windows(n, [row for annotations in self.placed for row in annotations.rows])
        again = self.again
        spans = [span for span in spans if again is None or again.rows_in(first, span)]
        for i, span in enumerate(spans):
            advanced = _reporter(self.task, done=i, of=len(spans))
            said = self._track_window(span, advanced=advanced)
            if said is None:
                return False
            self.said = self.said or said
        return True

    def as_attributes(self) -> dict[str, float | str]:
        """Return what tracks say of how they were made; of weighing what the first window said."""
        first = self.task.frames[0]
        points, weighing = self.layout.points, self.weighing
        return {
            "body_frame": "; ".join(self.said),
            **({} if weighing is None else weighing_as_attributes(weighing, points)),
            LEARNT_IN: learnt_as_text(self.learnt, points, first),
            **doubted_as_attributes(self.doubted),
        }

    def _track_window(
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
        own, framing = (
            with_extents(placed, self.layout.sizes, self.layout.rig) for placed in (own, framing)
        )
        used = [v for v, annotations in enumerate(own) if annotations.rows]
        if not used:
            return []
        stacks = self._stacks(span, [own[v] for v in used], framing, used, advanced)
        if stacks is None:
            return None
        inputs = self._inputs(span, dict(zip(used, stacks, strict=True)), own)
        if self.task.stop is not None and self.task.stop():  # a slow kind was broken off, too
            return None
        first, n_points, again = self.task.frames[0], len(self.layout.points), self.again
        rows = None if again is None else again.rows_in(first, span)
        weighing = (
            weigh(inputs, n_points, self.parameters)
            if again is None
            else weighing_of(again.tracks, self.layout.points)
        )
        self.weighing = self.weighing or weighing
        self.doubted += find_doubted_clicks(
            weighing.left_out, points=self.layout.points, rig=self.layout.rig,
            placed=dict(zip(self.layout.views, self.placed, strict=True)), rows=(first, begin),
        )  # fmt: skip
        results = run_pipeline(
            inputs, n_points=n_points, parameters=self.parameters, rig=self.layout.rig,
            rows=rows, weighing=weighing,
        )  # fmt: skip
        for v, one, result in zip(used, inputs, results, strict=True):
            chance = chance_to_go_on(self.placed[v], self.found[v], begin=begin, end=end)
            part = one.stack if rows is None else one.stack.part(*rows)
            track = view_track(part, result.points, n_points, chance=chance)
            take_over(self.found[v], track, begin + (rows or (0, 0))[0])
            self._take_training_frames(one.name, result.learnt, begin)
        self.stacks.keep_evidence(
            stacks, self._asked,
            {one.name: own.evidence for one, own in zip(inputs, results, strict=True)},
        )  # fmt: skip
        return [one.how_framed() for one in inputs]

    def _inputs(
        self, span: tuple[int, int], stacks: Mapping[int, BodyStack], own: Sequence[Annotations]
    ) -> list[ViewInput]:
        """Return what comes into the pipeline for each view that is used, in one window."""
        begin, end = span
        first, points, again = self.task.frames[0], self.layout.points, self.again
        frames, radius = (first + begin, first + end), self.parameters.appearance.radius
        inputs, kinds = [], [*installed_evidence(), *self.task.evidence]
        kept = self.stacks.evidence(list(stacks.values()), self._asked)
        for v, stack in stacks.items():
            detections = detections_of_others(
                self.layout, self.task, stack, annotations=own[v], view=v, span=span, kinds=kinds
            )
            one = ViewInput(self.layout.views[v], self.layout.sizes[v], stack, own[v], detections)
            if again is not None:
                known = again.known(one.name, points, first).part(begin, end)
                earlier = again.earlier(one.name, points, frames=frames, stack=stack, radius=radius)
                found, rows = kept.get(one.name), again.rows_in(first, span)
                same = found and rows and found.unchanged(own[v], rows)
                one = dataclasses.replace(one, known=known, earlier=earlier, kept=same or None)
            inputs.append(one)
        return inputs

    def _take_training_frames(self, view: str, learnt: Learnt, begin: int) -> None:
        """Take what was learnt in a window; how far kinds agree is that of the first one."""
        whole = self.learnt.get(view, Learnt({}, learnt.agreement))
        moved = {begin + row: own for row, own in learnt.training_frames.items()}
        self.learnt[view] = Learnt({**moved, **whole.training_frames}, whole.agreement)

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


def _reporter(task: TrackingRequest, *, done: int, of: int) -> Callable[[int], bool]:
    """Return what tells a person how far the video is read, and asks whether to go on."""
    n = task.frames[1] - task.frames[0]

    def advanced(read: int) -> bool:
        if task.progress is not None:  # a window is read twice
            task.progress(min(n, (done * n + read * of // 2) // of), n)
        return task.stop is None or not task.stop()

    return advanced
