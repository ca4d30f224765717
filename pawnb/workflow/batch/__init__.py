"""Many trials, one process each, begun again where it stopped.

Comes in: trials. Goes out: the results of each, and a table of what came of it. ``run`` is the
call; ``places`` are where trials run, ``scheduler`` is a Dask scheduler as such a place, ``worker``
is what runs there.
"""

from pawnb import _lazy

_HOME = {
    "BatchReport": "pawnb.workflow.batch.run",
    "batch": "pawnb.workflow.batch.run",
    "find_trials": "pawnb.workflow.batch.run",
    "is_tracked": "pawnb.workflow.batch.run",
}

__all__ = [
    "BatchReport",
    "batch",
    "find_trials",
    "is_tracked",
    "places",
    "renamed",
    "run",
    "scheduler",
    "worker",
]

__getattr__, __dir__ = _lazy(__name__, __all__, _HOME)
