"""The paw tracker after Haji Maghsoudi et al. 2019."""

from pawnb.core.paws.settings import PaperSettings
from pawnb.core.paws.task import Task
from pawnb.core.paws.tracker import track_paws

__all__ = ["PaperSettings", "Task", "track_paws"]
