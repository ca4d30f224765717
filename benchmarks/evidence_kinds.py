"""What each kind of evidence of the learnt tracker is worth: each alone, and all together.

python benchmarks/evidence_kinds.py [--clips NAME ...] [--clicks 1 3] [--out FILE.csv]

Prints % of visible marks of real clips that are right, as real_clips.py counts them, of points
tracked by learnt evidence from a few clicked frames: by motion (flow from the clicks), appearance
and correlation, each without the other two and with names that are not decided jointly, by all
three so, and by all with names decided jointly, which is what `pawnb track` does. The hidden
Markov model, its flow from frame to frame, the prior about the clicks and exclusion of places
are there in every column. Correlation is weighed by how far it agrees with the other kinds; alone
it has only the prior to agree with. Rows that are in FILE.csv are not computed again.
"""

from __future__ import annotations

import argparse
import contextlib
import dataclasses
import sys
import tempfile
from pathlib import Path
from unittest import mock

import numpy as np
import pandas as pd
import real_clip_marks as real
from real_clips import FINISHED, write_trial

from pawnb.cli import main as pawnb_command
from pawnb.core.paws.offline import learnt_run
from pawnb.core.paws.offline.parameters import OfflineParameters

_NOTHING = 1e-9
"""What a kind that is left out can add to a ratio of likelihoods."""
KINDS = {
    "motion": {"motion"},
    "appearance": {"appearance"},
    "correlation": {"correlation"},
    "three kinds": {"motion", "appearance", "correlation"},
    "three kinds, names jointly": {"motion", "appearance", "correlation", "names"},
}
"""Columns, and what each has."""


def parameters_of(kinds: set[str]) -> OfflineParameters:
    """Return the usual parameters without the kinds that are not named."""
    usual = OfflineParameters()
    motion, correlation, appearance = usual.motion, usual.correlation, usual.appearance
    if "motion" not in kinds:
        motion = dataclasses.replace(motion, gain=_NOTHING)
    if "correlation" not in kinds:
        correlation = dataclasses.replace(correlation, gain=1.0 + _NOTHING)
    if "appearance" not in kinds:
        appearance = dataclasses.replace(appearance, trust=0.0, trusts=(0.0,))
    return dataclasses.replace(
        usual, motion=motion, correlation=correlation, appearance=appearance,
        identity=usual.identity if "names" in kinds else None,
    )  # fmt: skip


def right(clip: real.Clip, n: int, kinds: set[str]) -> float:
    """Return % of marks that are right, tracked from n clicked frames by some kinds."""
    clicks, parameters = clip.clicks(n), parameters_of(kinds)
    with (
        tempfile.TemporaryDirectory() as made,
        mock.patch.object(learnt_run, "parameters_in_force", return_value=parameters),
    ):
        folder = write_trial(clip, clicks, Path(made))
        with contextlib.redirect_stdout(sys.stderr):
            done = pawnb_command(["track", str(folder), "--set", "evidence=learnt"])
        if done not in FINISHED:
            sys.exit(f"{clip.name} was refused")
        tracks = pd.read_csv(folder / "results" / "tracks.csv")
        found = real.compare(clip.marks, clicks, tracks, clip.threshold_px)
    return 100.0 * float(found["ok"].mean())


def parse() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--clips", nargs="+", metavar="NAME",
                        default=["horse_walk", "mouse_below_grey", "dog_indoors"])  # fmt: skip
    parser.add_argument("--clicks", nargs="+", type=int, default=[1, 3], metavar="N")
    parser.add_argument("--out", type=Path, metavar="FILE.csv", help="a row a clip and clicks")
    return parser.parse_args()


def main() -> None:
    options = parse()
    home = real.clips_folder()
    names = [name for name in options.clips if (home / name / "marks.csv").exists()]
    if not names:
        sys.exit(f"real clips: not in {home} (set PAWNB_TEST_DATA)")
    rows = []
    if options.out and options.out.exists():
        rows = pd.read_csv(options.out, dtype=str).to_dict("records")
    done = {(row["clip"], row["clicked frames"]) for row in rows}
    for name in names:
        clip = real.Clip(home / name)
        for n in options.clicks:
            if (name, str(n)) in done or clip.clicks(n) is None:
                continue
            shares = {column: right(clip, n, kinds) for column, kinds in KINDS.items()}
            rows.append({"clip": name, "clicked frames": str(n)}
                        | {column: f"{share:.0f}" for column, share in shares.items()})  # fmt: skip
            print(rows[-1], file=sys.stderr, flush=True)
            if options.out:
                pd.DataFrame(rows).to_csv(options.out, index=False)
    table = pd.DataFrame(rows)
    print(table.to_string(index=False))
    for column in KINDS:
        print(f"mean, {column}: {np.mean(table[column].astype(float)):.0f}")


if __name__ == "__main__":
    main()
