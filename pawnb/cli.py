"""The commands of ``pawnb``, from ``demo`` and ``check`` to ``lab``.

Exit status 0 on success, 2 on bad input with one sentence on standard error.
"""

from __future__ import annotations

import argparse
import sys
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NoReturn

import pawnb
from pawnb.errors import InputError, InputWarning, PawnbError
from pawnb.workflow.words import split_event_names, split_legs, split_settings

EXIT_BAD_INPUT = 2
EXIT_INTERRUPTED = 130


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command.

    Parameters
    ----------
    argv : sequence of str, optional
        Words after ``pawnb``; default those of the command line.

    Returns
    -------
    int
        0 on success, 2 on bad input, 130 when interrupted.
    """
    words = list(sys.argv[1:] if argv is None else argv)
    options = _parser().parse_args(words)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", InputWarning)
        status = _run(options, ["pawnb", *words])
    for warning in caught:
        if issubclass(warning.category, InputWarning):
            print(f"pawnb: note: {warning.message}", file=sys.stderr)
        else:
            warnings.warn_explicit(
                warning.message, warning.category, warning.filename, warning.lineno
            )
    return status


def _run(options: argparse.Namespace, argv: list[str]) -> int:
    """Run the chosen command and turn what it raises into an exit status."""
    try:
        options.run(options, argv)
    except PawnbError as error:
        print(f"pawnb: {error}", file=sys.stderr)
        return EXIT_BAD_INPUT
    except KeyboardInterrupt:
        print("pawnb: interrupted", file=sys.stderr)
        return EXIT_INTERRUPTED
    return 0


class _Parser(argparse.ArgumentParser):
    """Says what is wrong in one sentence instead of printing the usage too."""

    def error(self, message: str) -> NoReturn:
        self.exit(EXIT_BAD_INPUT, f"{self.prog}: {message}; see {self.prog} --help.\n")


def _parser() -> argparse.ArgumentParser:
    """Build the parser of all commands."""
    parser = _Parser(prog="pawnb", description="Video of a running animal to gait statistics.")
    parser.add_argument("--version", action="version", version=f"pawnb {pawnb.__version__}")
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)
    _add_demo(commands)
    _add_check(commands)
    _add_track(commands)
    _add_batch(commands)
    _add_gait(commands)
    _add_evaluate(commands)
    _add_compare(commands)
    _add_convert(commands)
    _add_lab(commands)
    return parser


def _add_demo(commands: Any) -> None:
    text = "render a synthetic trial with its truth, ready to track"
    command = commands.add_parser("demo", help=text, description=text)
    command.add_argument(
        "scene",
        choices=["paws", "spider"],
        help="paws: a mouse on a treadmill; spider: a spider seen from above",
    )
    command.add_argument("--out", default=None, help="folder to write (default: demo-SCENE)")
    command.add_argument("--frames", type=int, default=120, help="how many (default: 120)")
    command.add_argument(
        "--scale",
        type=float,
        default=0.5,
        help="1 is 2048 x 700 px a view, of the spider 1280 x 1024 px (default: 0.5)",
    )
    command.add_argument("--seed", type=int, default=0, help="another animal (default: 0)")
    command.set_defaults(run=_demo)


def _add_check(commands: Any) -> None:
    text = "say what a trial has, what is missing, and what looks wrong"
    command = commands.add_parser("check", help=text, description=text)
    command.add_argument("trial", help="trial.toml, or the folder that holds it")
    command.set_defaults(run=_check)


def _add_track(commands: Any) -> None:
    text = "track the points, or the pose, of a trial"
    command = commands.add_parser("track", help=text, description=text)
    command.add_argument("trial", help="trial.toml, or the folder that holds it")
    command.add_argument("--out", help="folder to write (default: results beside the trial)")
    command.add_argument(
        "--method",
        default=None,
        help="pawnb (default); paper: the published method (paws 2019, poses 2009); slic-3d, "
        "slic-2d: lesser variants of that of paws",
    )
    command.add_argument(
        "--set", action="append", default=[], metavar="NAME=VALUE", help="a setting of the tracker"
    )
    command.set_defaults(run=_track)


def _add_batch(commands: Any) -> None:
    text = "track many trials, one process each; run again, it goes on where it stopped"
    command = commands.add_parser("batch", help=text, description=text)
    command.add_argument(
        "trials", nargs="+", metavar="TRIAL", help="trials, or folders that hold folders of trials"
    )
    where = command.add_mutually_exclusive_group()
    where.add_argument("--workers", type=int, help="trials at once on this machine (default: 1)")
    where.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="track on the workers of a Dask scheduler instead, such as tcp://cluster:8786",
    )
    command.add_argument(
        "--out", help="folder for a folder of results each (default: results beside each trial)"
    )
    command.add_argument("--method", help="as for pawnb track")
    command.add_argument(
        "--set", action="append", default=[], metavar="NAME=VALUE", help="a setting of the tracker"
    )
    command.set_defaults(run=_batch)


def _add_gait(commands: Any) -> None:
    text = "events, strides, phases and figures; several inputs are pooled by animal"
    command = commands.add_parser("gait", help=text, description=text)
    command.add_argument(
        "inputs",
        nargs="+",
        metavar="TRIAL|RESULTS|TRACKS|EVENTS",
        help="a trial, its results folder, a tracks file, or an events.csv scored by hand",
    )
    command.add_argument("--out", help="folder to write (default: results beside the first input)")
    command.add_argument("--fps", type=float, help="frame rate, where the input does not say")
    command.add_argument(
        "--legs",
        nargs="+",
        metavar="LEG[=POINT]",
        help="legs to use (default: all); with =POINT its name in the file, as HR=hindpaw_R",
    )
    command.add_argument(
        "--animals", nargs="+", metavar="ID", help="whose each input is, in their order"
    )
    command.add_argument(
        "--event-names",
        nargs="+",
        metavar="NAME=EVENT",
        help="what a table of events calls them, as down=TD up=LO",
    )
    command.add_argument(
        "--figures",
        choices=["all", "main", "none"],
        default="all",
        help="which figures to draw (default: all that the tables allow)",
    )
    command.set_defaults(run=_gait)


def _add_evaluate(commands: Any) -> None:
    text = "errors of results against truth, or against tracks made by hand"
    command = commands.add_parser("evaluate", help=text, description=text)
    command.add_argument("results", metavar="RESULTS", help="folder of results, or a tracks.nc")
    command.add_argument(
        "truth", metavar="TRUTH", help="folder with pose.csv or tracks.csv, or one of these files"
    )
    command.add_argument(
        "--threshold",
        type=float,
        default=20.0,
        metavar="PX",
        help="points further off than this are wrong (default: 20, for pictures 2048 px wide)",
    )
    command.add_argument("--out", help="folder to write the tables to")
    command.set_defaults(run=_evaluate)


def _add_compare(commands: Any) -> None:
    text = "compare methods of the tracker on trials with truth, as the 2019 paper does"
    command = commands.add_parser("compare", help=text, description=text)
    command.add_argument(
        "trials", nargs="+", metavar="TRIAL", help="trial with truth/tracks.csv beside it"
    )
    command.add_argument("--methods", help="names with commas between (default: all)")
    command.add_argument(
        "--out", default="comparison", help="folder to write (default: %(default)s)"
    )
    command.add_argument("--frames", type=int, help="track only so many frames of each trial")
    command.add_argument(
        "--no-corrections",
        action="store_true",
        help="do not count with corrections, which tracks again after each",
    )
    command.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="[METHOD.]NAME=VALUE",
        help="a setting of every method that has it, or of one, as paper.n_superpixels=150",
    )
    command.set_defaults(run=_compare)


def _add_convert(commands: Any) -> None:
    text = "tracks of another program to those of pawnb, or to tables"
    command = commands.add_parser("convert", help=text, description=text)
    command.add_argument(
        "source", metavar="IN", help="of DeepLabCut, SLEAP, Anipose, DLTdv, movement or pawnb"
    )
    command.add_argument("target", metavar="OUT", help="tracks.nc, tracks.csv or points3d.csv")
    command.add_argument("--fps", type=float, help="frame rate, where the input does not say")
    command.add_argument("--from", dest="program", help="whose file it is (default: as it looks)")
    command.add_argument("--unit", help="unit of 3D points, where the input does not say")
    command.set_defaults(run=_convert)


def _add_lab(commands: Any) -> None:
    text = "open JupyterLab on the notebooks, on 127.0.0.1"
    command = commands.add_parser("lab", help=text, description=text)
    command.add_argument("notebook", nargs="?", help="default: 00_quickstart.ipynb")
    command.add_argument("--no-browser", action="store_true", help="print the address only")
    command.add_argument("--port", type=int, help="default: a free one from 8888 on")
    command.set_defaults(run=_lab)


def _demo(options: argparse.Namespace, _argv: list[str]) -> None:
    from pawnb.synthetic import render_mouse_trial, render_spider_trial
    from pawnb.workflow.progress import progress_bar

    render = render_spider_trial if options.scene == "spider" else render_mouse_trial
    out = Path(options.out or f"demo-{options.scene}")
    with progress_bar("rendering") as progress:
        path = render(
            out,
            frames=options.frames,
            scale=options.scale,
            seed=options.seed,
            progress=progress,
        )
    print(f"wrote {path}; next: pawnb track {path.parent}")


def _check(options: argparse.Namespace, _argv: list[str]) -> None:
    from pawnb.workflow.check import check_trial

    report = check_trial(options.trial)
    print(report.text())
    if report.faults:
        raise InputError(report.verdict())


def _track(options: argparse.Namespace, argv: list[str]) -> None:
    from pawnb.trial import load_trial
    from pawnb.workflow.interrupt import interruptible
    from pawnb.workflow.methods import METHODS
    from pawnb.workflow.results import results_folder
    from pawnb.workflow.track import track

    trial = load_trial(options.trial)
    out = results_folder(trial, options.out)
    with interruptible() as interrupted:
        tracks = track(
            trial,
            method=options.method or METHODS[0],
            settings=split_settings(options.set),
            out=out,
            stop=interrupted,
            command=argv,
        )
    if interrupted():
        print(f"tracked {tracks.sizes['time']} frames and wrote {out}; run it again to go on")
        raise KeyboardInterrupt
    print(f"tracked {tracks.sizes['time']} frames; wrote {out}; next: pawnb gait {out}")


def _batch(options: argparse.Namespace, argv: list[str]) -> None:
    from pawnb.workflow.batch import batch

    done = batch(
        options.trials,
        method=options.method,
        settings=split_settings(options.set),
        out=options.out,
        workers=options.workers,
        scheduler=options.scheduler,
        report=lambda line: print(line, flush=True),
        command=argv,
    )
    print(done.text())
    if (done.table["status"] == "stopped").any():
        print("run it again to go on")
        raise KeyboardInterrupt
    if len(done.failed):
        raise InputError(done.verdict())


def _gait(options: argparse.Namespace, argv: list[str]) -> None:
    from pawnb.workflow.gait import run_gait

    done = run_gait(
        options.inputs,
        out=options.out,
        fps=options.fps,
        legs=split_legs(options.legs),
        event_names=split_event_names(options.event_names),
        animals=options.animals,
        figures=options.figures,
        command=argv,
    )
    print(done.text())


def _evaluate(options: argparse.Namespace, _argv: list[str]) -> None:
    from pawnb.workflow.evaluate import evaluate

    found = evaluate(
        options.results, options.truth, threshold_px=options.threshold, out=options.out
    )
    print(found.text)


def _compare(options: argparse.Namespace, _argv: list[str]) -> None:
    from pawnb.workflow.compare import compare_methods
    from pawnb.workflow.methods import METHODS

    methods = options.methods.split(",") if options.methods else METHODS
    comparison = compare_methods(
        options.trials,
        methods=[name.strip() for name in methods],
        settings=split_settings(options.set),
        frames=None if options.frames is None else (0, options.frames),
        corrections=not options.no_corrections,
        out=options.out,
        report=print,
    )
    print(comparison.text())
    print(f"wrote {options.out}")


def _convert(options: argparse.Namespace, _argv: list[str]) -> None:
    from pawnb.workflow.convert import convert_tracks

    path = convert_tracks(
        options.source,
        options.target,
        fps=options.fps,
        program=options.program,
        unit=options.unit,
    )
    print(f"wrote {path}")


def _lab(options: argparse.Namespace, _argv: list[str]) -> None:
    from pawnb.workflow.lab import open_lab

    open_lab(options.notebook, browser=not options.no_browser, port=options.port)


if __name__ == "__main__":
    sys.exit(main())
