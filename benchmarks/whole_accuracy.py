"""How well the whole-recording tracker tracks: rendered scenes with exact truth.

Run it from the project's root:

    python benchmarks/whole_accuracy.py --render scenes --seeds 0 1 2 3 4 --scales 0.5 1
    python benchmarks/whole_accuracy.py --render scenes --vary --seeds 21 22 23 24 25
    python benchmarks/whole_accuracy.py --trials my/a/trial.toml my/b/trial.toml
    python benchmarks/whole_accuracy.py --render scenes --vary --alone --clicked 0.5
    python benchmarks/whole_accuracy.py --render scenes --vary --alone --scales 1 0.5 --films

Errors are counted twice. *Alone*: each scene is tracked once from its start clicks; what
is wrong makes runs of wrong frames, major and minor. *Corrected*: where a major error
begins, the truth is put in place, tracking goes on from there, and that is one
intervention. The rule is in pawnb/workflow/evaluation/errors.py. A label is wrong beyond 20 px in a
picture 2048 px wide, and a hidden one is bridged within half of that.

Rates are per 1000 frames of all views together; "<" is the upper end of the exact 95 %
interval of a Poisson count (Garwood 1936). Intervals of shares are exact, too (Clopper and
Pearson 1934), as if labels were independent, which those of one run are not. Distances
are px of the picture as it is. With ``--clicked`` wrong labels are also counted before and after
the frame that was clicked.

With ``--films`` the same scenes are filmed in several ways, by default in colour, in grey and
compressed (H.264, crf 23 and 28; made of the colour film where that is kept), and the last table
has, side by side, how many of 1000 visible labels are wrong, and the verdicts; a film that
tracking refuses has none right. Time is of the whole call, decoding and the checksums of the
record included, and of one correction. ``--out FILE.csv`` keeps a row a film
(docs/accuracy/films.csv); rows of other films that are there already stay.
"""

from __future__ import annotations

import argparse
import itertools
import re
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from refilm import can_refilm, refilm
from scipy.stats import beta

from pawnb.core.paws.offline.quality.assessment import assess
from pawnb.core.video import open_views
from pawnb.errors import PawnbError
from pawnb.schema import Tracks
from pawnb.synthetic import render_mouse_trial
from pawnb.trial import Trial, load_trial
from pawnb.workflow.evaluation.corrected_run import track_with_corrections
from pawnb.workflow.evaluation.errors import THRESHOLD_PX, count_errors, poisson_limit
from pawnb.workflow.tracking.track import retrack, track

REFERENCE_WIDTH_PX = 2048
COUNTS = {"major": "alone major", "minor": "alone minor", "interventions": "interventions",
          "minor_left": "then minor"}  # fmt: skip
SHARES = {"wrong": ("n_wrong", "n_labels"), "bridged": ("n_bridged", "n_hidden"),
          "inside 95 %": ("n_inside", "n_coordinates")}  # fmt: skip
SIDES = {side: (f"n_wrong_{side}", f"n_{side}") for side in ("before", "after")}
NEAR_FRAMES = 25
GOOD_FILM = "colour"
FILMS = (GOOD_FILM, "grey", "h264-crf23", "h264-crf28", "grey,h264-crf23", "grey,h264-crf28")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    add_scene_arguments(parser)
    parser.add_argument("--alone", action="store_true", help="leave out the corrections")
    parser.add_argument("--clicked", type=float, metavar="SHARE",
                        help="clicks so far into a recording (0 to 1), by the truth")  # fmt: skip
    parser.add_argument("--out", type=Path, metavar="FILE.csv", help="a row a film")
    arguments = parser.parse_args()
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for path in trials(arguments, arguments.render or Path(folder)):
            trial = load_trial(path)
            try:
                rows.append(
                    measure(trial, corrected=not arguments.alone, clicked=arguments.clicked)
                )
            except PawnbError as error:
                rows.append(refused(trial))
                print(f"{trial.name}: refused: {error}", flush=True)
            else:
                print(line(rows[-1]), flush=True)
            if arguments.out:
                keep_films(pd.DataFrame(rows), arguments.out)
    table = pd.DataFrame(rows)
    if not table["refused"].all():
        print(summary(table[~table["refused"]]))
    if len(films(arguments)) > 1:
        print("\nwrong of 1000 visible labels\n")
        print(side_by_side(table))


def add_scene_arguments(parser: argparse.ArgumentParser) -> None:
    """Let a benchmark be told its scenes: those given, or which are rendered and kept where."""
    parser.add_argument("--trials", type=Path, nargs="*", help="trials with truth/ beside them")
    parser.add_argument("--render", type=Path, metavar="FOLDER",
                        help="keep rendered scenes here, and use those that are there")  # fmt: skip
    parser.add_argument("--difficulty", nargs="*", default=["easy", "normal", "hard"])
    parser.add_argument("--seeds", type=int, nargs="*", default=[0, 1, 2])
    parser.add_argument("--frames", type=int, default=300, help="(%(default)s)")
    parser.add_argument("--scales", type=float, nargs="*", default=[0.5],
                        help="of 2048 x 700 (%(default)s)")  # fmt: skip
    parser.add_argument("--vary", action="store_true",
                        help="vary frame rate, views, speed, colours, light")  # fmt: skip
    parser.add_argument("--films", nargs="*", default=[GOOD_FILM], metavar="NAME[,NAME...]",
                        help=f"variants of `pawnb demo paws`, {GOOD_FILM} without any; no name: "
                        f"{' '.join(FILMS)} (%(default)s)")  # fmt: skip


def films(arguments: argparse.Namespace) -> list[str]:
    """Return how scenes are filmed; given without a name it means all that are compared."""
    return arguments.films or list(FILMS)


def trials(arguments: argparse.Namespace, folder: Path) -> Iterator[Path]:
    """Yield trial files: those given, else rendered ones."""
    if arguments.trials:
        yield from arguments.trials
        return
    for scale, difficulty, seed, film in itertools.product(
        arguments.scales, arguments.difficulty, arguments.seeds, films(arguments)
    ):
        variants = [] if film == GOOD_FILM else film.split(",")
        colour = "-".join([difficulty, f"{seed:02d}", f"{scale:g}", str(arguments.frames)])
        name = "-".join([colour, *variants])
        in_colour = folder / colour / "trial.toml"
        if (folder / name / "trial.toml").exists():  # the last file that is written
            yield folder / name / "trial.toml"
        elif can_refilm(variants) and in_colour.exists():
            yield refilm(in_colour, folder / name, variants)
        else:
            yield render_mouse_trial(
                folder / name, frames=arguments.frames, scale=scale, seed=seed,
                difficulty=difficulty, settings=variation(seed) if arguments.vary else None,
                variants=variants,
            )  # fmt: skip


def scene_seed(name: str) -> str:
    """Return the seed of a rendered scene by its folder's name: what scenes share by chance."""
    number = re.search(r"\d+", name)
    return name if number is None else str(int(number[0]))


def variation(seed: int) -> dict[str, Any]:
    """Return scene settings that differ as rigs and animals do, the same for the same seed."""
    rng = np.random.default_rng([seed, 17])
    dark = float(rng.uniform(20, 90))
    return {
        "fps": float(rng.choice([150.0, 200.0, 250.0, 250.0, 300.0, 400.0])),
        "n_views": int(rng.choice([2, 3, 4, 4, 4, 4])),
        "direction": int(rng.choice([1, -1])),
        "belt_speed_mm_s": float(rng.uniform(200, 500)),
        "belt_rgb": tuple(float(c) for c in rng.uniform(60, 160, 3)),
        "fur_rgb": tuple(float(np.clip(dark + d, 5, 130)) for d in rng.uniform(-12, 12, 3)),
        "light": float(rng.uniform(0.7, 1.2)),
        "light_azimuth_deg": float(rng.uniform(-180, 180)),
        "size": float(rng.uniform(0.85, 1.15)),
    }


def silent(_done: int, _total: int) -> None:
    """Show no progress."""


def clicks_at(trial: Trial, truth: pd.DataFrame, share: float) -> pd.DataFrame:
    """Return the truth of a frame so far into a recording as clicks on what the start's are on.

    Of the frames about there the nearest is taken in which most of it is visible.
    """
    start = pd.read_csv(trial.folder / "start.csv")[["view", "point"]]
    shown = start.merge(truth[truth["visible"] == 1])
    count = shown.groupby("frame").size()
    away = (count.index.to_series() - share * truth["frame"].max()).abs()
    near = pd.DataFrame({"count": -count, "away": away})[away <= NEAR_FRAMES]
    frame = near.sort_values(["count", "away"]).index[0]
    return shown.loc[shown["frame"] == frame, ["frame", "view", "point", "u", "v"]]


def measure(trial: Trial, *, corrected: bool, clicked: float | None = None) -> dict[str, object]:
    """Track one trial and compare it with its truth, alone and corrected."""
    truth = pd.read_csv(trial.folder / "truth" / "tracks.csv")
    with open_views(trial) as views:
        width = max(reader.width for reader in views.readers.values())
    threshold = THRESHOLD_PX * width / REFERENCE_WIDTH_PX
    points = {view.name: view.points for view in trial.views if view.points} or None
    limits: dict[str, Any] = {"points_by_view": points, "threshold_px": threshold}
    start = None if clicked is None else clicks_at(trial, truth, clicked)
    began = time.perf_counter()
    tracks = track(trial, start=start, progress=silent)
    took = time.perf_counter() - began
    report = count_errors(tracks, truth, hidden_px=threshold / 2, **limits)
    inside = coordinates_inside(tracks, trial)
    row = {
        "trial": trial.name, "refused": False, "width": width,
        "by": tracks.attrs["evidence"], "verdict": assess(tracks).verdict,
        "frames": report.n_frames, "major": report.major,
        "minor": report.minor, "n_labels": report.n_labels, "n_hidden": report.n_hidden,
        "n_wrong": round(report.share_wrong * report.n_labels),
        "n_bridged": round(np.nan_to_num(report.share_hidden_bridged) * report.n_hidden),
        "median": report.median_px, "p95": report.p95_px, "centred": report.median_px_centred,
        "p95_centred": report.p95_px_centred, "n_inside": int(inside.sum()),
        "n_coordinates": inside.size, "s": took, "interventions": np.nan, "minor_left": np.nan,
        "s_each": np.nan, "distances": report.distances_px * REFERENCE_WIDTH_PX / width,
    }  # fmt: skip
    if start is not None:
        frame = int(start["frame"].min())
        parts = {"before": truth["frame"] < frame, "after": truth["frame"] > frame}
        for side, rows in parts.items():
            part = count_errors(tracks, truth[rows], **limits)
            row[f"n_{side}"] = part.n_labels
            row[f"n_wrong_{side}"] = round(part.share_wrong * part.n_labels)
    if corrected:
        began = time.perf_counter()
        run = track_with_corrections(
            tracks, truth, lambda t, frame: retrack(trial, t, frame, progress=silent), **limits
        )
        frames = max(1, run.interventions["frame"].nunique())
        row["s_each"] = (time.perf_counter() - began) / frames
        row["interventions"], row["minor_left"] = len(run.interventions), run.report.minor
    return row


def refused(trial: Trial) -> dict[str, object]:
    """Return the row of a trial that tracking refuses: every visible label is wrong."""
    truth = pd.read_csv(trial.folder / "truth" / "tracks.csv")
    points = pd.DataFrame(
        [(view.name, point) for view in trial.views for point in view.points],
        columns=["view", "point"],
    )
    n = int(truth.merge(points)["visible"].sum())
    with open_views(trial) as views:
        width = max(reader.width for reader in views.readers.values())
    return {"trial": trial.name, "refused": True, "width": width, "n_labels": n, "n_wrong": n}


def coordinates_inside(tracks: Tracks, trial: Trial) -> np.ndarray:
    """Tell which true coordinates lie inside the stated 95 % intervals."""
    truth = pd.read_csv(trial.folder / "truth" / "points3d.csv")
    inside = []
    for point in tracks["keypoint"].to_numpy().tolist():
        own = truth[truth["point"] == point].set_index("frame")
        true = own.loc[tracks["frame"].to_numpy(), ["x", "y", "z"]].to_numpy()
        here = tracks.sel(keypoint=point).isel(individual=0)
        away = np.abs(here["position"].to_numpy() - true)
        inside.append(away < 1.96 * here["sd"].to_numpy())
    return np.stack(inside)


def line(row: dict[str, object]) -> str:
    """Return one line about one trial."""
    r = pd.Series(row)
    bridged = r["n_bridged"] / max(1, r["n_hidden"])
    text = (
        f"{r['trial']:22s} {r['width']:4d} px {r['frames']:4d} frames: "
        f"major {r['major']} minor {r['minor']} wrong {r['n_wrong'] / r['n_labels']:.2%}; "
        f"median {r['median']:.2f} 95th {r['p95']:.1f} (offsets removed {r['centred']:.2f} "
        f"{r['p95_centred']:.1f}) px; bridged {bridged:.0%}; "
        f"inside {r['n_inside'] / r['n_coordinates']:.1%}; {r['verdict']}, by {r['by']}; "
        f"{r['s']:.1f} s"
    )
    for side in SIDES:
        if f"n_{side}" in r:
            text += f"; {side} {r[f'n_wrong_{side}'] / r[f'n_{side}']:.2%}"
    if np.isfinite(r["interventions"]):
        text += f"; corrected {r['interventions']:.0f}, then minor {r['minor_left']:.0f}"
        text += f" ({r['s_each']:.1f} s each)" if r["interventions"] else ""
    return text


def summary(table: pd.DataFrame) -> str:
    """Return rates by difficulty, with their upper bounds."""
    kind = table["trial"].str.extract(r"synthetic-(\w+)-", expand=False).fillna("other")
    lines = []
    for name, part in table.groupby(kind):
        frames = int(part["frames"].sum())
        rates = []
        for column, said in COUNTS.items():
            if part[column].notna().all():
                count = int(part[column].sum())
                rates.append(f"{said} {count}: {1000 * count / frames:.2f} "
                             f"< {1000 * poisson_limit(count) / frames:.2f}")  # fmt: skip
        shares = []
        for said, (k, n) in (SHARES | SIDES).items():
            if n not in part:
                continue
            hits, of = int(part[k].sum()), int(part[n].sum())
            low, high = share_interval(hits, of)
            shares.append(f"{said} {hits / max(1, of):.2%} ({low:.2%} to {high:.2%})")
        middle, far = np.percentile(np.concatenate(part["distances"].tolist()), (50, 95))
        worst = (
            f"median {middle:.2f}, 95th {far:.1f} px of {REFERENCE_WIDTH_PX}; "
            f"worst scene {part['median'].max():.2f}, {part['p95'].max():.1f} px"
        )
        lines += [f"{name}: {len(part)} scenes, {frames} frames; per 1000: " + "; ".join(rates),
                  "    " + "; ".join(shares) + f"; {worst}"]  # fmt: skip
    return "\n".join(lines)


def film_names(table: pd.DataFrame) -> pd.DataFrame:
    """Add what the names of rendered scenes tell: difficulty, seed, film; and the even width."""
    parts = table["trial"].str.extract(r"^synthetic-(\w+)-(\d+)-?(.*)$").fillna("other")
    return table.assign(
        scenes=parts[0],
        seed=parts[1],
        film=parts[2].replace("", GOOD_FILM),
        width=(table["width"] + 1) // 2 * 2,  # H.264 has even widths only
    )


def keep_films(table: pd.DataFrame, path: Path) -> None:
    """Write a row a film; a row of the same film that is there is replaced, others stay."""
    table = film_names(table)
    rate = (1000 * table["n_wrong"] / table["n_labels"]).map("{:.1f}".format)
    refused = table["refused"].astype(bool)
    rows = pd.DataFrame({
        "scenes": table["scenes"], "seed": table["seed"], "px wide": table["width"].astype(str),
        "film": table["film"].str.replace("grey-", "grey and "),
        "visible labels": table["n_labels"].astype(str),
        "wrong per 1000": rate.where(~refused, "refused"),
        "verdict": table.get("verdict", ""),
        "found by": table.get("by", ""),
    })  # fmt: skip
    if path.exists():
        rows = pd.concat([pd.read_csv(path, dtype=str), rows])
    key = ["scenes", "px wide", "seed", "film"]
    places = rows.drop_duplicates(key)[key]  # a row that is replaced stays where it was
    rows = places.merge(rows.drop_duplicates(key, keep="last"), on=key)[rows.columns]
    rows.to_csv(path, index=False)


def side_by_side(table: pd.DataFrame) -> str:
    """Return in Markdown how many of 1000 visible labels are wrong, a column a film."""
    table = film_names(table)
    shown = list(dict.fromkeys(table["film"]))
    lines = ["| scenes | px wide | " + " | ".join(shown) + " |", "|---" * (2 + len(shown)) + "|"]
    for (scenes, width), here in table.groupby(["scenes", "width"], sort=False):
        cells = []
        for film in shown:
            own = here[here["film"] == film]
            rate = 1000 * own["n_wrong"].sum() / max(1, own["n_labels"].sum())
            no = f" ({own['refused'].sum()} of {len(own)} refused)" if own["refused"].any() else ""
            said = ", ".join(f"{n} {verdict}" for verdict, n in verdicts(own).items())
            cells.append(f"{rate:.1f}{no}" + f" ({said})" * bool(said) if len(own) else "")
        lines.append(f"| {scenes} | {width} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def verdicts(table: pd.DataFrame) -> dict[str, int]:
    """Return how many scenes were given each verdict."""
    return table["verdict"].value_counts().to_dict() if "verdict" in table else {}


def share_interval(hits: int, of: int) -> tuple[float, float]:
    """Return the exact 95 % interval of a share."""
    low = 0.0 if not hits else float(beta.ppf(0.025, hits, of - hits + 1))
    return low, 1.0 if hits >= of else float(beta.ppf(0.975, hits + 1, of - hits))


if __name__ == "__main__":
    main()
