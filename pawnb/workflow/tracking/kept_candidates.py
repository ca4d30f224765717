"""Where the evidence of method ``pawnb`` is kept between runs and corrections."""

from __future__ import annotations

import contextlib
import json
from collections import OrderedDict
from collections.abc import Iterator
from pathlib import Path

from pawnb.core.paws.offline.detection.colour.cache import DetectionCache
from pawnb.core.paws.offline.reuse.kept_evidence import KeptStacks
from pawnb.trial import Trial
from pawnb.workflow.provenance.record import file_checksum

CANDIDATES_FILE = "candidates.bin"

_MOST_IN_MEMORY = 2
_in_memory: OrderedDict[str, DetectionCache] = OrderedDict()
_stacks: OrderedDict[str, KeptStacks] = OrderedDict()


def open_store(trial: Trial, folder: Path | None) -> DetectionCache:
    """Return the store for a run that tracks a trial.

    Parameters
    ----------
    trial : Trial
        What was filmed.
    folder : Path, optional
        Folder of its results, in which the file is kept; without it candidates stay in
        memory.

    Returns
    -------
    DetectionCache
        The store; hand it to :func:`keep_store` after the run.
    """
    if folder is not None:
        return DetectionCache(folder / CANDIDATES_FILE, source=describe_source(trial))
    return reopen_store(trial, None)


def reopen_store(trial: Trial, folder: Path | None) -> DetectionCache:
    """Return the store of an earlier run on a trial, for tracking again.

    Parameters
    ----------
    trial : Trial
        What was filmed.
    folder : Path, optional
        Folder of its results.

    Returns
    -------
    DetectionCache
        The one in memory, else that of the folder, else an empty one.
    """
    source = describe_source(trial)
    # taken out while it is in use: two runs at once never share one
    store = _in_memory.pop(source, None)
    if store is None:
        path = None if folder is None else folder / CANDIDATES_FILE
        store = DetectionCache(path if path and path.exists() else None, source=source)
    return store


def keep_store(store: DetectionCache) -> None:
    """Keep a store in memory for what is tracked next; the oldest of several is let go."""
    store.close()
    _in_memory[store.source] = store
    while len(_in_memory) > _MOST_IN_MEMORY:
        _in_memory.popitem(last=False)


def session_stacks(source: str) -> KeptStacks:
    """Return the pictures and flow that this session keeps of a recording.

    Those of the recording used longest ago are let go.

    Parameters
    ----------
    source : str
        What was filmed, see :func:`describe_source`.
    """
    kept = _stacks.pop(source, None) or KeptStacks()
    _stacks[source] = kept
    while len(_stacks) > _MOST_IN_MEMORY:
        _stacks.popitem(last=False)
    return kept


@contextlib.contextmanager
def new_session() -> Iterator[None]:
    """Keep nothing of what this session has kept, until the end of the context."""
    stores, stacks = _in_memory.copy(), _stacks.copy()
    _in_memory.clear()
    _stacks.clear()
    try:
        yield
    finally:
        _in_memory.clear()
        _in_memory.update(stores)
        _stacks.clear()
        _stacks.update(stacks)


def describe_source(trial: Trial) -> str:
    """Return a text that changes whenever a picture of any view may."""
    views = [
        {
            "video": file_checksum(trial.path(view.video)),
            "crop": view.crop,
            "mirror": view.mirror,
            "bayer": view.bayer,
            "offset": view.offset,
        }
        for view in trial.views
    ]
    said = trial.calibration
    lens = None if said is None else said.lens or said.cameras
    lenses = None if lens is None else file_checksum(trial.path(lens))
    return json.dumps({"views": views, "lens": lenses}, sort_keys=True)
