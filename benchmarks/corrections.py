"""What a review brings: the worst point of each marked frame corrected, and tracked again.

Run it from the project's root:

    python benchmarks/corrections.py
    python benchmarks/corrections.py --clips dog_indoors horse_walk --out corrections.csv

A clip is tracked from its own clicks. Then the marked frames are gone through in order; in each the
point that is farthest from its mark, and not right, is put there in that one view, and the frames
up to its next click are tracked again in the same session (:func:`pawnb.retrack`), as a person
does with TrackReviewer. Marks that were corrected do not count. Only what is learnt in the
recording is used, as it is tracked again in parts.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

import pandas as pd
import real_clip_marks as real
from points_speed import quiet, timed
from real_clips import write_trial

from pawnb.core.edits.log import EditLog, Move, Retrack
from pawnb.core.rig import load_rig
from pawnb.io.native import tracks_table
from pawnb.io.start import read_start
from pawnb.schema import Tracks
from pawnb.trial import load_trial
from pawnb.workflow.tracking.track import retrack, track


def judge(clip: real.Clip, clicks: pd.DataFrame, tracks: Tracks) -> pd.DataFrame:
    """Return the marks that count, with how far from them the tracks are."""
    return real.compare(clip.marks, clicks, tracks_table(tracks), clip.threshold_px)


def measure(clip: real.Clip, folder: Path) -> dict[str, object]:
    """Return what corrections brought on one clip."""
    trial = load_trial(write_trial(clip, clip.start, folder) / "trial.toml")
    start = read_start(trial.path(trial.start_file()), trial)
    tracks = track(trial, start=start, settings={"evidence": "learnt"}, progress=quiet)
    first = judge(clip, start, tracks)
    log = EditLog(
        tracks, rig=load_rig(trial),
        retrack=lambda t, f, **given: retrack(trial, t, f, progress=quiet, **given),
    )  # fmt: skip
    corrected: list[tuple[int, str, str]] = []
    seconds = []
    for frame in sorted(set(first["frame"])):
        now = judge(clip, start, log.tracks)
        wrong = now[(now["frame"] == frame) & ~now["ok"]]
        if wrong.empty:
            continue
        worst = wrong.loc[wrong["distance"].fillna(float("inf")).idxmax()]
        place = {name: worst[name] for name in ("view", "point", "u", "v")}
        log.apply(Move(frame=int(frame), **place))
        _, took = timed(lambda frame=frame: log.apply(Retrack(frame=int(frame))))
        corrected.append((int(frame), worst["view"], worst["point"]))
        seconds.append(took.cpu)
    last = judge(clip, start, log.tracks)
    keys = pd.MultiIndex.from_tuples(corrected, names=["frame", "view", "point"])
    others = ~pd.MultiIndex.from_frame(first[["frame", "view", "point"]]).isin(keys)
    return {
        "clip": clip.name, "corrections": len(corrected), "other marks": int(others.sum()),
        "right before": int(first["ok"][others].sum()),
        "right after": int(last["ok"][others].sum()),
        "processor time of each, s": round(pd.Series(seconds).median(), 2),
    }  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--clips", nargs="+", help="default: all real clips")
    parser.add_argument("--out", type=Path, help="a csv to write")
    options = parser.parse_args()
    folders = [path.parent for path in sorted(real.clips_folder().glob("*/meta.toml"))]
    rows = []
    for folder in folders:
        if options.clips and folder.name not in options.clips:
            continue
        with tempfile.TemporaryDirectory() as made:
            rows.append(measure(real.Clip(folder), Path(made)))
        print("; ".join(f"{name} {value}" for name, value in rows[-1].items()), flush=True)
    if options.out:
        pd.DataFrame(rows).to_csv(options.out, index=False)


if __name__ == "__main__":
    main()
