"""Learn how likely labels are right from what is measured of them.

python benchmarks/learn_calibration.py [--clips NAME ...] [--clicks 1 2 3 5] [--cache FOLDER]
    [--learn-from NAME ...] [--without SIGN ...]

Tracks real clips with marks (see real_clip_marks.py) by learnt evidence from a few clicked frames
and takes the signs (`offline/quality/signs.py`) of the labels that have a mark. A logistic
regression, in which no sign may count against its meaning, gives the weights of
`offline/quality/calibration.py`; each clip and number of clicked frames weighs the same. What
left-out clicks say depends on the weights, which are learnt three times over. Every clip is then
judged by weights learnt from all other recordings: share right and expected, verdicts, how often
a wrong label has a smaller chance than a right one (AUROC), and marks inside the 95 % intervals.
Clips of one film are one recording (``recording`` in meta.toml; else each clip is one). Then come
the recordings, by these weights and by those in force: what is doubted where a tenth of the right
marks of the others is, and how much more, with its 95 % interval by drawing recordings again. Last
come the weights that all clips together give. --learn-from learns from some clips only, and
--without leaves signs out.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
import pandas as pd
import real_clip_marks as real
import xarray as xr
from real_clips import markdown, number, percent, write_trial
from scipy.optimize import minimize
from scipy.special import expit

import pawnb
from pawnb.core.paws.offline import learnt_run
from pawnb.core.paws.offline.parameters import RUN
from pawnb.core.paws.offline.quality.calibration import of_all_views, standard_deviation
from pawnb.core.paws.offline.quality.labels import QualityLimits
from pawnb.core.paws.offline.quality.left_out import LeftOutClick, offsets
from pawnb.core.paws.offline.quality.parameters import QUALITY
from pawnb.core.paws.offline.quality.signs import SIGNS
from pawnb.core.paws.offline.self_training import weighing

CELL_WEIGHT = 20.0
"""What the marks of a clip, tracked from so many clicked frames, weigh together; a weight of
one standard deviation of a sign costs one half."""

ROUNDS = 3
"""Times that weights are learnt again with what left-out clicks say by the weights before."""

STRICTER = 0.4
"""The offset is so much below the fit: doubt in vain costs less than none. 0.2, 0.3, 0.4, 0.5 and
0.6 give 15, 16, 16, 15 and 15 right verdicts of 18, and doubt of 65, 67, 71, 75 and 76 % of wrong
labels, 7, 7, 8, 8 and 10 % of right ones."""

RIGHT_DOUBTED = 0.1
"""Share of the right marks of other recordings that a threshold of doubt may take: the aim."""

DRAWS = 2000
"""Times that recordings are drawn again."""

LEAST_CHANCE = 1e-4
"""What surely is right or wrong, and is not, counts as if it had so much probability."""


def parse() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--clips", nargs="+", metavar="NAME", help="(default: all that are there)")
    parser.add_argument("--clicks", nargs="+", type=int, default=[1, 2, 3, 5], metavar="N")
    parser.add_argument("--cache", type=Path, metavar="FOLDER", help="keeps what was measured")
    parser.add_argument("--learn-from", nargs="+", metavar="NAME", help="(default: all clips)")
    signs = [sign for sign in SIGNS if sign != "left_out"]
    parser.add_argument("--without", nargs="+", choices=signs, default=[], metavar="SIGN")
    return parser.parse_args()


def main() -> None:
    options = parse()
    home = real.clips_folder()
    there = sorted(path.parent.name for path in home.glob("*/marks.csv"))
    names = [name for name in options.clips or there if name in there]
    films = {real.Clip(home / name).recording for name in names}
    if len(films) < 2:
        sys.exit(f"two recordings are needed in {home} (set PAWNB_TEST_DATA); has {len(films)}.")
    with tempfile.TemporaryDirectory() as made:
        cache = options.cache or Path(made)
        cache.mkdir(parents=True, exist_ok=True)
        cells = [cell(real.Clip(home / c), n, cache) for c in names for n in options.clicks]
    marks, left_out = zip(*[one for one in cells if one is not None], strict=True)
    even = dict.fromkeys(options.without, 0.0)
    tables = (pd.concat(own, ignore_index=True).assign(**even) for own in (marks, left_out))
    report(*tables, learn_from=options.learn_from)


def cell(clip: real.Clip, n: int, cache: Path) -> tuple[pd.DataFrame, pd.DataFrame] | None:
    """Track a clip, or take what was measured earlier: its marks and the clicks left out.

    None where marks are too few.
    """
    clicks, kept = clip.clicks(n), cache / f"{clip.name}-{n}.csv"
    left_out = kept.with_name(f"{clip.name}-{n}-left-out.csv")
    if clicks is None:
        return None
    if not (kept.exists() and left_out.exists()):
        with (
            tempfile.TemporaryDirectory() as made,
            mock.patch.object(learnt_run, "view_track", wraps=learnt_run.view_track) as seen,
            mock.patch.object(weighing, "offsets", wraps=weighing.offsets) as heard,
        ):
            trial = pawnb.load_trial(write_trial(clip, clicks, Path(made)))
            tracks = pawnb.track(trial, settings={"evidence": "learnt"})
        views = dict(zip(_clicked_views(tracks, clicks), seen.call_args_list, strict=True))
        found = real.compare(clip.marks, clicks, None, clip.threshold_px)
        points = tracks["keypoint"].to_numpy().tolist()
        rows = pd.Series(range(tracks.sizes["time"]), index=tracks["frame"].to_numpy())
        signs = measure(
            found, views, clip.threshold_px, points=points, rows=rows,
            calibrated=tracks.sizes["space"] == 3,
        )  # fmt: skip
        clicked = [click for call in heard.call_args_list for click in call.args[0]]
        pd.DataFrame(
            [{"point": c.point, "right": c.right, **dict(zip(SIGNS, c.signs, strict=True))}
             for c in clicked], columns=["point", "right", *SIGNS],
        ).to_csv(left_out, index=False)  # fmt: skip
        signs.to_csv(kept, index=False)
        print(f"{clip.name}, {n}: tracked", file=sys.stderr)
    named = {"recording": clip.recording, "clip": clip.name, "clicks": n}
    return pd.read_csv(kept).assign(**named), pd.read_csv(left_out).assign(**named)


def _clicked_views(tracks: xr.Dataset, clicks: pd.DataFrame) -> list[str]:
    """Return the views in which anything was clicked, in the order of the tracks."""
    return [name for name in tracks["view"].to_numpy().tolist() if name in set(clicks["view"])]


def measure(
    marks: pd.DataFrame,
    views: dict[str, Any],
    px: float,
    *,
    points: list[str],
    rows: pd.Series,
    calibrated: bool,
) -> pd.DataFrame:
    """Return for each mark whether its label is right, its signs, how far off and how exact.

    Signs of calibrated views are means over the views, as what they say is.
    """
    found = []
    for mark in marks.itertuples():
        stack, tracks, _ = views[mark.view].args
        row, p = int(rows[mark.frame]), points.index(mark.point)
        own = tracks[p]
        off = stack.picture_of(own.found.place[row], row) - [mark.u, mark.v]
        told = [view.args[1] for view in views.values()] if calibrated else [tracks]
        of_views = [one[p].signs for one in told if p in one]
        columns = np.mean([signs.columns()[row] for signs in of_views], axis=0)
        probability = of_all_views(np.array([signs.probability[row] for signs in of_views]))[0]
        found.append({
            "point": p, "ok": np.hypot(*off) <= px,
            "off_u": off[0], "off_v": off[1], **dict(zip(SIGNS, columns, strict=True)),
            "probability": probability if calibrated else own.signs.probability[row],
            "sd_px": own.found.sd[row] * stack.spacing / stack.scale, "extent": stack.extent_px,
        })  # fmt: skip
    return pd.DataFrame(found)


def learn(marks: pd.DataFrame, left_out: pd.DataFrame) -> tuple[np.ndarray, float]:
    """Return the weight of every sign, and the offset."""
    weights, offset = fit(marks)
    for _ in range(ROUNDS):
        weights, offset = fit(heard(marks, left_out, weights, offset))
    return weights, offset


def heard(
    marks: pd.DataFrame, left_out: pd.DataFrame, weights: np.ndarray, offset: float
) -> pd.DataFrame:
    """Return marks with what left-out clicks say by these weights."""
    said = {}
    for cell, own in left_out.groupby(["clip", "clicks"]):
        clicks = [
            LeftOutClick(
                int(row["point"]), np.nan, bool(row["right"]), row[[*SIGNS]].to_numpy(float)
            )
            for _, row in own.iterrows()
        ]
        found = offsets(clicks, log_odds=lambda signs: signs @ weights + offset)
        said |= {(*cell, point): value for point, value in found.items()}
    keys = marks[["clip", "clicks", "point"]].itertuples(index=False, name=None)
    return marks.assign(left_out=[said.get(key, 0.0) for key in keys])


def fit(cells: pd.DataFrame) -> tuple[np.ndarray, float]:
    """Return the weight of every sign, and the offset, by logistic regression."""
    x, ok = cells[list(SIGNS)].to_numpy(float), cells["ok"].to_numpy(bool)
    weight = CELL_WEIGHT / cells.groupby(["clip", "clicks"])["ok"].transform("size").to_numpy()
    middle = np.average(x, axis=0, weights=weight)
    spread = np.sqrt(np.average((x - middle) ** 2, axis=0, weights=weight)) + 1e-9
    z = np.column_stack([np.ones(len(x)), (x - middle) / spread])

    def cost(w: np.ndarray) -> tuple[float, np.ndarray]:
        odds = z @ w
        off = weight * (expit(odds) - ok)
        loss = weight @ np.logaddexp(0, np.where(ok, -odds, odds)) + 0.5 * w[1:] @ w[1:]
        return float(loss), z.T @ off + np.concatenate([[0.0], w[1:]])

    bounds = [(None, None), *[(0, None) if s > 0 else (None, 0) for s in SIGNS.values()]]
    w = minimize(cost, np.zeros(z.shape[1]), jac=True, bounds=bounds).x
    weights = w[1:] / spread
    return weights, float(w[0] - weights @ middle) - STRICTER


def report(
    labels: pd.DataFrame, left_out: pd.DataFrame, *, learn_from: Sequence[str] | None = None
) -> None:
    """Print how every clip is judged by weights learnt from other recordings, and the weights."""
    clips = learn_from or labels["clip"].unique()
    taught, heard_of = (table["clip"].isin(clips).to_numpy() for table in (labels, left_out))
    ok, here = labels["ok"].to_numpy(bool), labels["recording"].to_numpy()
    chance, limits = np.empty(len(labels)), np.empty(len(labels))
    for recording in labels["recording"].unique():
        own, known = here == recording, (left_out["recording"] == recording).to_numpy()
        weights, offset = learn(labels[taught & ~own], left_out[heard_of & ~known])
        said = chances(labels, left_out, weights, offset)
        chance[own], limits[own] = said[own], np.quantile(said[ok & ~own], RIGHT_DOUBTED)
    labels = labels.assign(chance=chance)
    rows = [judge(clip, n, own) for (clip, n), own in labels.groupby(["clip", "clicks"])]
    print(markdown(pd.DataFrame(rows)))
    print(f"\n{whole(rows, ok, chance)}")
    in_force = chances(labels, left_out, np.array(QUALITY.weights), QUALITY.offset)
    before = np.array([np.quantile(in_force[ok & (here != one)], RIGHT_DOUBTED) for one in here])
    ways = {"": (chance, limits), "in force: ": (in_force, before)}
    print(f"\n{markdown(by_recording(labels, ways))}")
    print(f"\n{gained(labels, chance < limits, in_force < before)}")
    runs = labels.groupby(["clip", "clicks"]).indices.values()
    right = sum(verdict(in_force[own].mean()) == verdict(ok[own].mean()) for own in runs)
    print(f"verdicts right by the weights in force: {right} of {len(runs)}")
    weights, offset = learn(labels[taught], left_out[heard_of])
    print("weights:", dict(zip(SIGNS, weights.round(2).tolist(), strict=True)))
    print(f"offset: {offset:.2f}, from {taught.sum()} marks")


def chances(
    labels: pd.DataFrame, left_out: pd.DataFrame, weights: np.ndarray, offset: float
) -> np.ndarray:
    """Return how likely labels are right by these weights."""
    marks = heard(labels, left_out, weights, offset)
    odds = marks[list(SIGNS)].to_numpy(float) @ weights + offset
    return np.minimum(expit(odds), marks["probability"].to_numpy())


def whole(rows: list[dict[str, str]], ok: np.ndarray, chance: np.ndarray) -> str:
    """Return what is said of all marks together."""
    right = sum(row["verdict"] == row["deserved"] for row in rows)
    likelihood = np.log(np.clip(np.where(ok, chance, 1.0 - chance), LEAST_CHANCE, 1.0)).mean()
    below = percent(chance[~ok] < np.quantile(chance[ok], 0.1))
    wrong, sound = percent(chance[~ok] < RUN.measured), percent(chance[ok] < RUN.measured)
    return (
        f"verdicts right: {right} of {len(rows)}; "
        f"AUROC of all marks together: {real.auroc(-chance, ~ok):.3f}\n"
        f"mean log-likelihood {likelihood:.3f}; below a tenth of the right marks: "
        f"{below} % of wrong ones\n"
        f"doubted: {wrong} % of wrong marks, {sound} % of right ones"
    )


def by_recording(
    labels: pd.DataFrame, ways: dict[str, tuple[np.ndarray, np.ndarray]]
) -> pd.DataFrame:
    """Return a row for each recording; ``ways`` has chances, and the limits of doubt."""
    ok, rows = labels["ok"].to_numpy(bool), []
    for recording, own in labels.groupby("recording").indices.items():
        right = ok[own]
        row = {"recording": str(recording), "wrong marks": f"{(~right).sum()} of {len(own)}"}
        for way, (chance, limits) in ways.items():
            doubted = chance[own] < limits[own]
            row |= {
                f"{way}AUROC": number(real.auroc(-chance[own], ~right), 2),
                f"{way}unsure of wrong %": percent(doubted[~right]),
                f"{way}of right %": percent(doubted[right]),
            }
        rows.append(row)
    return pd.DataFrame(rows)


def gained(labels: pd.DataFrame, doubted: np.ndarray, before: np.ndarray) -> str:
    """Return how many more wrong marks are doubted, and how sure that is."""
    wrong = labels.assign(more=doubted.astype(int) - before)[~labels["ok"].to_numpy(bool)]
    sums = wrong.groupby("recording")["more"].agg(["sum", "size"]).to_numpy(float)
    drawn = np.random.default_rng(0).integers(0, len(sums), (DRAWS, len(sums)))
    gains = 100 * sums[drawn, 0].sum(axis=1) / sums[drawn, 1].sum(axis=1)
    low, high = np.quantile(gains, [0.025, 0.975])
    return (
        f"wrong marks doubted more than by the weights in force: "
        f"{100 * wrong['more'].mean():.1f} in a hundred ({low:.1f} to {high:.1f})"
    )


def judge(clip: str, n: int, own: pd.DataFrame) -> dict[str, str]:
    """Return a row of the table: a clip tracked from n clicked frames."""
    ok, chance = own["ok"].to_numpy(bool), own["chance"].to_numpy()
    sd = standard_deviation(own["sd_px"].to_numpy(), chance, own["extent"].to_numpy())
    inside = np.abs(own[["off_u", "off_v"]].to_numpy()) <= 1.96 * sd[:, None]
    return {
        "clip": clip, "clicked frames": str(n), "marks": str(len(own)),
        "right %": percent(ok), "expected %": f"{100 * chance.mean():.0f}",
        "verdict": verdict(float(chance.mean())), "deserved": verdict(float(ok.mean())),
        "AUROC": number(real.auroc(-chance, ~ok), 2),
        "unsure of wrong %": percent(chance[~ok] < RUN.measured),
        "of right %": percent(chance[ok] < RUN.measured),
        "inside 95 % interval %": percent(inside),
    }  # fmt: skip


def verdict(share: float) -> str:
    """Return the verdict that a share of right labels deserves."""
    limits = QualityLimits()
    return "good" if share >= limits.good else "look" if share >= limits.failed else "failed"


if __name__ == "__main__":
    main()
