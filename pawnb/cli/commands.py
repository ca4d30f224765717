"""What each command does: it calls the workflow and prints what was found."""

from __future__ import annotations

import argparse
import json
import sys
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pawnb.cli.shared import print_json
from pawnb.errors import InputError
from pawnb.files import as_word
from pawnb.workflow.words import split_event_names, split_legs, split_settings

if TYPE_CHECKING:
    from pawnb.schema import Tracks


def run_open(options: argparse.Namespace, _argv: list[str]) -> None:
    """Open the workbench."""
    from pawnb.workflow.workbench.page import open_page

    open_page(options.paths, browser=not options.no_browser, port=options.port)


def run_new(options: argparse.Namespace, _argv: list[str]) -> None:
    """Make a trial by questions."""
    from pawnb.workflow.workbench.questions import ask_new_trial

    path = ask_new_trial(options.videos, folder=options.out)
    print(f"wrote {path}; next: pawnb open {as_word(path.parent)}")


def run_demo(options: argparse.Namespace, _argv: list[str]) -> None:
    """Render a synthetic trial."""
    from pawnb.synthetic import render_mouse_trial, render_spider_trial
    from pawnb.workflow.progress import progress_bar

    variants = [name.strip() for name in options.vary.split(",") if name.strip()]
    if variants and options.scene != "paws":
        raise InputError(f"--vary {options.vary}: only pawnb demo paws has variants.")
    more: dict[str, Any] = {"variants": variants} if variants else {}
    render = render_spider_trial if options.scene == "spider" else render_mouse_trial
    out = Path(options.out or f"demo-{options.scene}")
    with progress_bar("rendering") as progress:
        path = render(
            out,
            frames=options.frames,
            scale=options.scale,
            seed=options.seed,
            progress=progress,
            **more,
        )
    print(f"wrote {path}; next: pawnb track {as_word(path.parent)}")


def run_check(options: argparse.Namespace, _argv: list[str]) -> None:
    """Say what a trial has and lacks."""
    from pawnb.workflow.checking.check import check_trial

    report = check_trial(options.trial)
    if options.json:
        print_json(**vars(report))
    else:
        print(report.text())
    if report.faults:
        raise InputError(report.verdict())


def run_track(options: argparse.Namespace, argv: list[str]) -> int:
    """Track a trial, write its results and say how good they are."""
    from pawnb.core.paws.tracker import DEFAULT
    from pawnb.core.pose.as_tracks import is_pose
    from pawnb.trial import load_trial
    from pawnb.workflow.interrupt import interruptible
    from pawnb.workflow.provenance.results import results_folder
    from pawnb.workflow.reviewing.quality import EXIT_FAILED, assess_quality, next_step
    from pawnb.workflow.tracking.track import track

    trial = load_trial(options.trial)
    out = results_folder(trial, options.out)
    with interruptible() as interrupted:
        tracks = track(
            trial,
            method=options.method or DEFAULT,
            settings=split_settings(options.set),
            out=out,
            stop=interrupted,
            command=argv,
        )
    if interrupted():
        print(f"tracked {tracks.sizes['time']} frames; run it again to go on")
        raise KeyboardInterrupt
    quality = assess_quality(tracks)
    said = f"tracked {tracks.sizes['time']} frames: {quality.line()}"
    after = next_step(quality, out, of_poses=is_pose(tracks))
    print(f"{said}; wrote {out}; next: {after}")
    if lacks := _say_lacking(tracks, out / "edits.jsonl"):
        print(f"look: {lacks}")
    return EXIT_FAILED if quality.verdict == "failed" else 0


def _say_lacking(tracks: Tracks, edits: Path) -> str:
    """Say how many corrections that a person made new tracks lack; empty where none."""
    from pawnb.core.edits.log import say_unsaved

    try:
        return say_unsaved(tracks, edits) if edits.exists() else ""
    except InputError as error:
        return str(error)


def run_suggest(options: argparse.Namespace, _argv: list[str]) -> None:
    """Print the frames in which further clicks would help most."""
    from pawnb.trial import load_trial
    from pawnb.workflow.provenance.results import read_result_tracks, results_folder
    from pawnb.workflow.reviewing.suggest import suggest_frames

    trial = load_trial(options.trial)
    path = results_folder(trial, options.results) / "tracks.nc"
    if not path.exists():
        raise InputError(f"{path}: no such tracks; run pawnb track {as_word(options.trial)} first.")
    found = suggest_frames(trial, read_result_tracks(path), n=options.n)
    if options.json:
        rows = found.assign(points=found["points"].str.split(", ")).to_dict(orient="records")
        print(json.dumps(rows, ensure_ascii=False))
    elif found.empty:
        print("no frame: further clicks are expected to mend less than half a label each")
    else:
        print(found.to_string(index=False))


def run_batch(options: argparse.Namespace, argv: list[str]) -> int:
    """Track many trials."""
    from pawnb.workflow.batch.run import batch
    from pawnb.workflow.reviewing.quality import EXIT_FAILED

    done = batch(
        options.trials,
        method=options.method,
        settings=split_settings(options.set),
        out=options.out,
        workers=options.workers,
        scheduler=options.scheduler,
        report=partial(print, flush=True, file=sys.stderr if options.json else sys.stdout),
        command=argv,
    )
    if options.json:
        print_json(trials=done.table)
    else:
        print(done.text())
    if (done.table["status"] == "stopped").any():
        print("run it again to go on", file=sys.stderr if options.json else sys.stdout)
        raise KeyboardInterrupt
    if len(done.failed):
        raise InputError(done.verdict())
    return EXIT_FAILED if len(done.lost) else 0


def run_gait(options: argparse.Namespace, argv: list[str]) -> None:
    """Analyse gait and write tables and figures."""
    from pawnb.workflow.gait.run import run_gait

    done = run_gait(
        options.inputs,
        out=options.out,
        fps=options.fps,
        legs=split_legs(options.legs),
        event_names=split_event_names(options.event_names),
        animals=options.animals,
        groups=options.groups,
        settings=split_settings(options.set),
        figures=options.figures,
        command=argv,
    )
    if not options.json:
        print(done.text())
        return
    tables = done.tables
    print_json(
        out=str(done.out),
        files=[path.relative_to(done.out).as_posix() for path in done.files],
        n_animals=tables.events["animal"].nunique(),
        n_strides=len(tables.strides),
        n_dropped=len(tables.dropped),
        phase_summary=tables.phase_summary,
        notes=list(map(str, tables.notes)),
    )


def run_evaluate(options: argparse.Namespace, _argv: list[str]) -> None:
    """Print errors of results, or how steady poses are."""
    from pawnb.workflow.evaluation.evaluate import evaluate
    from pawnb.workflow.evaluation.evaluate_pose import evaluate_directions, evaluate_still

    asked = [options.truth is not None, options.still is not None, options.directions]
    if sum(asked) != 1:
        raise InputError("expected one of TRUTH, --still FIRST LAST and --directions.")
    _refuse_unheeded(options)
    if options.still is not None:
        still = evaluate_still(options.results, frames=tuple(options.still), out=options.out)
        _print_evaluation(still, options)
        return
    if options.directions:
        px, deg = options.disturb or (0.0, 0.0)
        both = evaluate_directions(
            options.results,
            method=options.method or "pawnb",
            disturb_px=px,
            disturb_deg=deg,
            out=options.out,
        )
        _print_evaluation(both, options)
        return
    found = evaluate(
        options.results, options.truth, threshold_px=options.threshold, out=options.out
    )
    _print_evaluation(found, options)


def _refuse_unheeded(options: argparse.Namespace) -> None:
    """Refuse an option of another question: its answer would look as if it had been heeded."""
    for name, is_heeded, of in (
        ("threshold", options.truth is not None, "TRUTH"),
        ("disturb", options.directions, "--directions"),
        ("method", options.directions, "--directions"),
    ):
        if getattr(options, name) is not None and not is_heeded:
            raise InputError(f"--{name} is for {of} and would not be heeded here; leave it out.")


def _print_evaluation(found: Any, options: argparse.Namespace) -> None:
    """Print errors in words, or as JSON."""
    if options.json:
        print_json(**found.tables)
    else:
        print(found.text)


def run_compare(options: argparse.Namespace, _argv: list[str]) -> None:
    """Compare methods on trials with truth."""
    from pawnb.trial import load_trial
    from pawnb.workflow.kinds import kind_of

    trials = [load_trial(path) for path in options.trials]
    asked: dict[str, Any] = {
        "settings": split_settings(options.set),
        "frames": None if options.frames is None else (0, options.frames),
        "out": options.out,
        # with --json standard output is one object
        "report": partial(print, file=sys.stderr) if options.json else print,
    }
    if options.methods:
        asked["methods"] = [name.strip() for name in options.methods.split(",")]
    corrections = not options.no_corrections
    comparison = kind_of(trials[0]).compare(trials, corrections=corrections, **asked)
    if options.json:
        print_json(**vars(comparison))
        return
    print(comparison.text())
    print(f"wrote {options.out}")


def run_convert(options: argparse.Namespace, _argv: list[str]) -> None:
    """Convert tracks."""
    from pawnb.workflow.conversion.convert import convert_tracks

    for path in convert_tracks(
        options.source,
        options.target,
        to=options.to,
        fps=options.fps,
        program=options.program,
        unit=options.unit,
        view=options.view,
        animal=options.animal,
        heights_px=options.heights,
        legs=split_legs(options.legs),
    ):
        print(f"wrote {path}")


def run_reproduce(options: argparse.Namespace, _argv: list[str]) -> int:
    """Make files again and say whether they are the same."""
    from pawnb.workflow.provenance.reproduce import (
        EXIT_DIFFERS,
        made_files,
        reproduce_all,
        tell_not_made,
    )

    named = map(Path, options.files)
    files = [file for path in named for file in (made_files(path) if path.is_dir() else [path])]
    found = reproduce_all(files, inputs=options.inputs)
    for one in found:
        if len(found) > 1 or one.fault is None:
            print(one.text())
    same = sum(one.identical for one in found)
    if len(found) > 1:
        print(f"{same} of {len(found)} identical", flush=True)
    if (fault := tell_not_made(found)) is not None:
        raise InputError(fault)
    return 0 if same == len(found) else EXIT_DIFFERS


def run_report(options: argparse.Namespace, argv: list[str]) -> None:
    """Write one page on an animal or a study."""
    from pawnb.workflow.provenance.report.report import write_report

    path = write_report(
        options.inputs if len(options.inputs) > 1 else options.inputs[0],
        out=options.out,
        fps=options.fps,
        legs=split_legs(options.legs),
        settings=split_settings(options.set),
        command=argv,
    )
    print(f"wrote {path}")


def run_selfcheck(options: argparse.Namespace, _argv: list[str]) -> int:
    """Check this installation."""
    from pawnb.workflow.checking.selfcheck import selfcheck
    from pawnb.workflow.reviewing.quality import EXIT_FAILED

    def tell(what: str) -> None:
        if sys.stderr.isatty() and not options.quiet:
            print(f"checking {what} ...", file=sys.stderr)

    found = selfcheck(trials=not options.values_only, progress=tell)
    if options.json:
        print_json(findings=[vars(one) for one in found.findings], right=found.right)
    else:
        print(found.text())
    return 0 if found.right else EXIT_FAILED


def run_lab(options: argparse.Namespace, _argv: list[str]) -> None:
    """Open JupyterLab."""
    from pawnb.workflow.lab import open_lab

    open_lab(options.notebook, browser=not options.no_browser, port=options.port)
