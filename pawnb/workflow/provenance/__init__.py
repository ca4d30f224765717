"""What was done, with what, to what, and what a folder of results holds.

Comes in: inputs, settings and results of a run. Goes out: records by which it can be made again.
``record`` makes the record that every result carries, ``manifest`` writes a folder whole and finds
faults in one, ``labels`` name inputs, ``results`` writes and reads what tracking made,
``mended_trial`` brings those to what the trial says now, ``notes`` lists warnings beside it.
``recipes`` reads what a file carries, ``find_inputs`` what it was made of; ``reproduce`` makes it
again, and ``same_content`` says in what it differs. ``report`` writes pages on a run.
"""

from pawnb import _lazy

_HOME = {
    "build_step": "pawnb.workflow.provenance.record",
    "file_checksum": "pawnb.workflow.provenance.record",
    "package_versions": "pawnb.workflow.provenance.record",
    "plain_command": "pawnb.workflow.provenance.record",
    "provenance_text": "pawnb.workflow.provenance.record",
    "trial_checksums": "pawnb.workflow.provenance.record",
    "trial_fingerprint": "pawnb.workflow.provenance.record",
    "trial_inputs": "pawnb.workflow.provenance.record",
}

__all__ = [
    "build_step",
    "file_checksum",
    "find_inputs",
    "labels",
    "manifest",
    "mended_trial",
    "notes",
    "package_versions",
    "plain_command",
    "provenance_text",
    "recipes",
    "record",
    "report",
    "reproduce",
    "results",
    "same_content",
    "trial_checksums",
    "trial_fingerprint",
    "trial_inputs",
]

__getattr__, __dir__ = _lazy(__name__, __all__, _HOME)
