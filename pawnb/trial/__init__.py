"""Trial: what was filmed and how; ``trial.toml`` in and out.

A trial only describes. It opens no video and reads no table; it does check that
what is written makes sense, so that a typing error is found before any work.
"""

from pawnb.trial.description import Animal, Bayer, Calibration, Trial, View
from pawnb.trial.document import trial_document, trial_from_document
from pawnb.trial.file import load_trial, save_trial
from pawnb.trial.kinds import Kind

__all__ = [
    "Animal",
    "Bayer",
    "Calibration",
    "Kind",
    "Trial",
    "View",
    "load_trial",
    "save_trial",
    "trial_document",
    "trial_from_document",
]


def __dir__() -> list[str]:
    """List the public names."""
    return sorted(__all__)
