"""How well points are tracked in real clips from a few clicked frames, beside two peers.

python benchmarks/real_clips.py [--clips NAME ...] [--clicks 1 2 3 5] [--peers [lk csrt]]
    [--csrt-python PYTHON] [--cache FOLDER] [--set NAME=VALUE ...] [--out MARKS.csv]

Prints % of visible marks, in frames that were not clicked, that have the track of the same point
within the clip's threshold, about half a paw. Marks of points that no click names do not count.
The clicks are marks of frames that are spread evenly, in one frame those of the clip's start.csv.
pawnb is `pawnb track` on a trial with these clicks; what it refuses counts 0 %. The peers are
described in real_clip_peers.py: CSRT needs the python of an environment with
opencv-contrib-python-headless. A cell holds 10 to 130 marks, so that it is good to 5 to 25 points.

Of pawnb a second table has: identity losses (wrong marks nearer to another point's mark than to
their own); wrong marks that the results themselves doubt, and right ones, in % (in the first 5 % of
suspects.csv within 3 frames, a confidence below 0.2, or predicted or missing); how often a wrong
mark has less confidence than a right one (AUROC); coordinates of marks inside the 95 % intervals,
where there is a standard deviation in px; time of the whole command over frames of the clip.
Clips: see real_clip_marks.py.
"""

from __future__ import annotations

import argparse
import hashlib
import subprocess
import sys
import tempfile
import time
import tomllib
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pandas as pd
import real_clip_marks as real
import tomli_w
from real_clip_peers import PEERS, VERSION

OURS = "pawnb"
NAMES = {OURS: "pawnb", "lk": "LK", "csrt": "CSRT"}
FOREIGN = {"fly_ball_left"}
"""Left out of one of the means: 15 frames in which tips jump."""
FINISHED = (0, 3)
"""Exit status of a run that wrote results; 3 says that its own verdict on them is: failed."""
PEER_WORKER = Path(__file__).with_name("real_clip_peers.py")
KEPT = ["clip", "clicks", "frame", "view", "point", "distance", "confidence", "ok", "method"]


@dataclass
class Run:
    """What one method made of one clip from clicks in so many frames."""

    clip: str
    clicks: int
    method: str
    found: pd.DataFrame
    refused: str = ""
    seconds_per_frame: float = np.nan
    verdict: str = ""
    said: np.ndarray = field(default_factory=lambda: np.empty(0, bool))
    inside: float = np.nan

    @property
    def right(self) -> float:
        """Marks that are right, %."""
        return 100.0 * float(self.found["ok"].mean())

    def details(self) -> dict[str, str]:
        """Return a row of the second table."""
        ok = self.found["ok"].to_numpy(bool)
        row = {"clip": self.clip, "clicked frames": str(self.clicks)}
        if self.refused:
            return row | {"right %": "refused"}
        doubt = -self.found["confidence"].fillna(0.0).to_numpy(float)
        return row | {
            "right %": f"{self.right:.0f}",
            "marks": str(len(ok)),
            "identity losses": str(int((self.found["took"] != "").sum())),
            "said of wrong %": percent(self.said[~ok]),
            "said of right %": percent(self.said[ok]),
            "verdict": self.verdict,
            "AUROC": number(real.auroc(doubt, ~ok), 2),
            "inside 95 % interval %": number(100 * self.inside, 0),
            "s per frame": number(self.seconds_per_frame, 2),
        }


def percent(hits: np.ndarray) -> str:
    """Return a share as text, nothing of no marks."""
    return f"{100 * hits.mean():.0f}" if len(hits) else ""


def number(value: float, digits: int) -> str:
    """Return a number as text, nothing where there is none."""
    return f"{value:.{digits}f}" if np.isfinite(value) else ""


def write_trial(clip: real.Clip, clicks: pd.DataFrame, folder: Path) -> Path:
    """Make a trial of a clip with other clicks; its videos and its calibration are linked."""
    document = tomllib.loads((clip.folder / "trial.toml").read_text())
    document["start"] = {"points": "start.csv"}
    made = {"trial.toml", "start.csv", "marks.csv", "results"}
    for path in clip.folder.iterdir():
        if path.name not in made:
            (folder / path.name).symlink_to(path.resolve())
    clicks.to_csv(folder / "start.csv", index=False)
    (folder / "trial.toml").write_text(tomli_w.dumps(document))
    return folder


def run_ours(clip: real.Clip, n: int, clicks: pd.DataFrame, settings: list[str]) -> Run:
    """Track a clip by the command, and judge what it writes."""
    with tempfile.TemporaryDirectory() as made:
        folder = write_trial(clip, clicks, Path(made))
        words = [sys.executable, "-m", "pawnb", "track", str(folder)]
        words += [word for setting in settings for word in ("--set", setting)]
        began = time.perf_counter()
        done = subprocess.run(words, capture_output=True, text=True, check=False)
        took = time.perf_counter() - began
        results = folder / "results"
        if done.returncode not in FINISHED or not (results / "tracks.csv").exists():
            said = done.stderr.strip().splitlines()
            found = real.compare(clip.marks, clicks, None, clip.threshold_px)
            return Run(clip.name, n, OURS, found, refused=said[-1] if said else "no word of why")
        tracks = pd.read_csv(results / "tracks.csv")
        found = real.compare(clip.marks, clicks, tracks, clip.threshold_px)
        suspects = pd.read_csv(results / "suspects.csv")
        return Run(
            clip.name, n, OURS, found,
            seconds_per_frame=took / tracks["frame"].nunique(),
            verdict=real.verdict(results),
            said=found["said"].to_numpy(bool) | real.in_suspects(found, suspects),
            inside=float(real.share_inside(found, results / "tracks.nc").mean()),
        )  # fmt: skip


def run_peer(
    peer: str, clip: real.Clip, n: int, clicks: pd.DataFrame, *, python: str | None, cache: Path
) -> Run | None:
    """Let a peer follow the clicks, or take what it found earlier; None where it cannot run."""
    asked = hashlib.sha256(clicks.to_csv(index=False).encode())
    asked.update((clip.folder / "trial.toml").read_bytes())
    asked.update(f"{clip.threshold_px} {VERSION}".encode())
    kept = cache / f"{clip.name}-{n}-{peer}-{asked.hexdigest()[:12]}.csv"
    if not kept.exists():
        if python is None:
            return None
        given, part = kept.with_suffix(".clicks"), kept.with_suffix(".part")
        clicks.to_csv(given, index=False)
        words = [python, PEER_WORKER, peer, clip.folder, given, part]
        words += ["--threshold-px", str(clip.threshold_px)]
        done = subprocess.run(words, capture_output=True, text=True, check=False)
        given.unlink()
        if done.returncode:
            said = done.stderr.strip().splitlines()[-1:]
            print(f"{NAMES[peer]} left out of {clip.name}: {' '.join(said)}", file=sys.stderr)
            return None
        part.rename(kept)
    found = real.compare(clip.marks, clicks, pd.read_csv(kept), clip.threshold_px)
    return Run(clip.name, n, peer, found)


def run_clip(clip: real.Clip, options: argparse.Namespace, cache: Path) -> list[Run]:
    """Run all methods on a clip."""
    python = {"lk": sys.executable, "csrt": options.csrt_python}
    runs = []
    for n in options.clicks:
        clicks = clip.clicks(n)
        if clicks is None:
            continue
        for peer in options.peers:
            run = run_peer(peer, clip, n, clicks, python=python[peer], cache=cache)
            runs += [run] if run else []
        if not options.only_peers:
            runs.append(run_ours(clip, n, clicks, options.set))
            if runs[-1].refused:
                print(f"{clip.name}, {n}: {runs[-1].refused}", file=sys.stderr)
        print(f"{clip.name}, {n}: {len(clicks)} clicks done", file=sys.stderr)
    return runs


def main_table(runs: list[Run], clicks: list[int], methods: list[str]) -> pd.DataFrame:
    """Return % of marks that are right by clip, method and clicked frames, and its means."""
    right = {(r.clip, r.method, r.clicks): r.right for r in runs}
    refused = {(r.clip, r.method, r.clicks) for r in runs if r.refused}
    clips = list(dict.fromkeys(r.clip for r in runs))
    means = {"mean": clips, **{f"mean without {name}": [c for c in clips if c != name]
                               for name in FOREIGN & set(clips) if len(clips) > 1}}  # fmt: skip
    rows = []
    for label, over in {**{clip: [clip] for clip in clips}, **means}.items():
        row = {"clip": label}
        for n in clicks:
            for method in methods:
                keys = [(clip, method, n) for clip in over]
                shares = [right[key] for key in keys if key in right]
                text = f"{np.mean(shares):.0f}" if shares else ""
                one = label in clips and keys[0] in refused
                row[f"{n}: {NAMES[method]}"] = "refused" if one else text
        rows.append(row)
    return pd.DataFrame(rows)


def markdown(table: pd.DataFrame) -> str:
    """Return a table in Markdown."""
    head = list(table.columns)
    rows = [head, ["---"] * len(head), *table.fillna("").to_numpy().tolist()]
    return "\n".join("| " + " | ".join(row) + " |" for row in rows)


def parse() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--clips", nargs="+", metavar="NAME", help="(default: all that are there)")
    parser.add_argument("--clicks", nargs="+", type=int, default=[1, 2, 3, 5], metavar="N")
    parser.add_argument("--peers", nargs="*", choices=PEERS, default=list(PEERS))
    parser.add_argument("--only-peers", action="store_true", help="leave pawnb out")
    parser.add_argument("--csrt-python", metavar="PYTHON", help="that has opencv-contrib")
    parser.add_argument("--cache", type=Path, metavar="FOLDER", help="keeps results of peers")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE",
                        help="a setting of pawnb's tracker")  # fmt: skip
    parser.add_argument("--out", type=Path, metavar="FILE.csv", help="for every mark")
    return parser.parse_args()


def main() -> None:
    options = parse()
    home = real.clips_folder()
    there = sorted(path.parent.name for path in home.glob("*/marks.csv"))
    if not there:
        print(f"real clips: not in {home} (set PAWNB_TEST_DATA)")
        return
    unknown = set(options.clips or []) - set(there)
    if unknown:
        sys.exit(f"no clip {', '.join(sorted(unknown))} in {home}; there are {', '.join(there)}.")
    runs = []
    with tempfile.TemporaryDirectory() as made:
        cache = options.cache or Path(made)
        cache.mkdir(parents=True, exist_ok=True)
        for name in options.clips or there:
            runs += run_clip(real.Clip(home / name), options, cache)
    methods = [] if options.only_peers else [OURS]
    print(markdown(main_table(runs, options.clicks, [*methods, *options.peers])))
    ours = [run.details() for run in runs if run.method == OURS]
    if ours:
        print("\n" + markdown(pd.DataFrame(ours)))
    if options.out:
        kept = [r.found.assign(clip=r.clip, clicks=r.clicks, method=r.method) for r in runs]
        part = options.out.with_suffix(".part")
        pd.concat(kept)[KEPT].round({"distance": 2}).to_csv(part, index=False)
        part.replace(options.out)


if __name__ == "__main__":
    main()
