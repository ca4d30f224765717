"""Whether this installation computes what it should: reference values and a trial of each kind."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from pawnb.schema.arguments import checked_arguments
from pawnb.synthetic import render_mouse_trial, render_spider_trial, write_deeplabcut_sample
from pawnb.trial import load_trial
from pawnb.workflow.checking.reference_values import REFERENCE_VALUES
from pawnb.workflow.evaluation.errors import count_errors, limits_for_width
from pawnb.workflow.evaluation.evaluate import evaluate
from pawnb.workflow.gait.run import run_gait
from pawnb.workflow.provenance.reproduce import reproduce
from pawnb.workflow.tracking.track import track

_SCALE = 0.25
_PAW_VIEW_PX = 2048 * _SCALE
_MOST_WRONG = 0.02
"""Share of visible labels; 0.3 to 1.2 % in pictures so small (seed 0, 60 to 120 frames)."""
_MOST_OFF_TIP = 0.01
"""Median error of a tip as a share of the leg's span; 0.2 % (seed 0)."""
_MOST_OFF_PERIOD = 0.02
"""Of the stride period of each animal; each sample's strides differ by 1 %."""
_DLC_FPS = 200.0


@dataclass(frozen=True)
class Finding:
    """One thing that was checked.

    Parameters
    ----------
    what : str
        What was computed.
    found : str
        What came out.
    expected : str
        What should come out, and where that stands.
    right : bool
        Whether it did.
    """

    what: str
    found: str
    expected: str
    right: bool


@dataclass(frozen=True)
class SelfCheck:
    """What :func:`selfcheck` found.

    Parameters
    ----------
    findings : tuple of Finding
        In the order in which they were checked.
    """

    findings: tuple[Finding, ...]

    @property
    def right(self) -> bool:
        """Whether all came out as expected."""
        return all(finding.right for finding in self.findings)

    def text(self) -> str:
        """Return one line for each, and one over all."""
        lines = [
            f"{'ok   ' if one.right else 'WRONG'} {one.what}: {one.found} (expected {one.expected})"
            for one in self.findings
        ]
        wrong = sum(not one.right for one in self.findings)
        n = len(lines)
        over_all = (
            f"all {n} checks came out as expected"
            if not wrong
            else f"{wrong} of {n} checks are wrong"
        )
        return "\n".join([*lines, over_all])


@checked_arguments
def selfcheck(*, trials: bool = True, progress: Callable[[str], None] | None = None) -> SelfCheck:
    """Check this installation: published values, and a rendered trial of each kind.

    Paws and a spider are rendered, tracked and compared with the truth, tracks in
    DeepLabCut's format are analysed, and a figure is made twice. It takes about a minute, and on
    a new installation some 20 s more, in which kernels are compiled. Nothing is left on the disk.

    Parameters
    ----------
    trials : bool
        Whether trials are checked, too; without them it takes a second.
    progress : callable, optional
        ``progress(what)``, told what comes next.

    Returns
    -------
    SelfCheck
        What was found.

    Examples
    --------
    >>> pawnb.selfcheck(trials=False).right
    True
    """
    findings = list(_reference_findings())
    if trials:
        with tempfile.TemporaryDirectory(prefix="pawnb-") as folder:
            for what, check in _TRIALS:
                if progress is not None:
                    progress(what)
                findings += check(Path(folder))
    return SelfCheck(tuple(findings))


def _reference_findings() -> Iterator[Finding]:
    """Compare values with those of their sources."""
    for value in REFERENCE_VALUES:
        found = value.compute()
        yield Finding(
            value.what,
            f"{found:.6g}",
            f"{value.expected:.6g}; {value.source}",
            bool(abs(found - value.expected) <= value.tolerance),
        )


def _quiet(_done: int, _total: int) -> None:
    """No bar."""


def _paws(folder: Path) -> list[Finding]:
    """Render, track and judge a mouse in four views."""
    path = render_mouse_trial(folder / "paws", frames=100, scale=_SCALE, progress=_quiet)
    tracks = track(load_trial(path), progress=_quiet)
    threshold_px, hidden_px = limits_for_width(_PAW_VIEW_PX)
    truth = pd.read_csv(path.parent / "truth" / "tracks.csv")
    errors = count_errors(tracks, truth, threshold_px=threshold_px, hidden_px=hidden_px)
    return [
        Finding(
            "labels wrong on a rendered mouse, four views",
            f"{errors.share_wrong:.1%}",
            f"at most {_MOST_WRONG:.0%}",
            bool(errors.share_wrong <= _MOST_WRONG),
        )
    ]


def _pose(folder: Path) -> list[Finding]:
    """Render, track and judge a spider."""
    path = render_spider_trial(folder / "spider", frames=120, scale=0.3, progress=_quiet)
    out = path.parent / "results"
    track(load_trial(path), out=out, progress=_quiet)
    summary = evaluate(out, path.parent / "truth").tables["summary"].set_index("measure")["value"]
    off, swaps = float(summary["tip error, median"]), int(summary["leg swaps"])
    return [
        Finding(
            "median error of a spider's tips, of the leg's span",
            f"{off:.1%}, {swaps} legs exchanged",
            f"at most {_MOST_OFF_TIP:.0%}, none exchanged",
            off <= _MOST_OFF_TIP and swaps == 0,
        )
    ]


def _gait(folder: Path) -> list[Finding]:
    """Analyse three animals from another program's files, and make a figure again."""
    files = write_deeplabcut_sample(folder / "others", animals=3)
    truth = pd.read_csv(folder / "others" / "truth.csv").set_index("animal")["period_s"]
    run = run_gait(files, fps=_DLC_FPS, out=folder / "gait", figures="main")
    found = run.tables.strides.groupby("animal")["period_s"].median()
    found.index = [str(name).removesuffix("DLC") for name in found.index]
    off = float((found.reindex(truth.index) / truth - 1).abs().max(skipna=False))
    figure = next(path for path in run.files if path.suffix == ".png")
    again = reproduce(figure, inputs=folder)
    return [
        Finding(
            "stride periods of three animals from DeepLabCut's files, off by",
            f"{off:.1%}",
            f"at most {_MOST_OFF_PERIOD:.0%}",
            off <= _MOST_OFF_PERIOD,
        ),
        Finding(
            "a figure made twice",
            "identical" if again.identical else "different",
            "identical",
            again.identical,
        ),
    ]


_TRIALS = (
    ("paws in four views", _paws),
    ("the pose of a spider", _pose),
    ("gait from other programs' tracks", _gait),
)
