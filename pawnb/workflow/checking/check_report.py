"""What was found on looking at a trial, in words."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass
class CheckReport:
    """What :func:`pawnb.check_trial` found, in words.

    Parameters
    ----------
    trial : str
        Name of the trial.
    found : list of str
        What is there.
    doubts : list of str
        What looks wrong but does not stop the work.
    faults : list of str
        What must be mended first.
    """

    trial: str
    found: list[str] = field(default_factory=list)
    doubts: list[str] = field(default_factory=list)
    faults: list[str] = field(default_factory=list)

    def text(self) -> str:
        """Return the report, one finding a line."""
        lines = [f"trial {self.trial}"]
        for mark, findings in (("ok", self.found), ("look", self.doubts), ("MEND", self.faults)):
            lines += [f"  {mark:4}  {finding}" for finding in findings]
        return "\n".join(lines)

    def verdict(self) -> str:
        """Return the faults as one sentence."""
        return f"trial {self.trial!r} cannot be worked on yet: " + "; ".join(
            fault.rstrip(".") for fault in self.faults
        )
