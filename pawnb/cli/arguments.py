"""What may stand behind ``pawnb`` on a command line."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import Any, NoReturn

import pawnb
from pawnb.cli import commands
from pawnb.cli.calibration import add_calibrate
from pawnb.cli.completion import SHELLS, completion_script
from pawnb.cli.shared import add_shared_options, name_meant
from pawnb.synthetic.variants import VARIANTS

EXIT_BAD_INPUT = 2
_VERDICT = (
    "The verdict on tracks: good, look (below 90 % of labels are expected to be right) or failed "
    "(below 50 %); quality.json says it point by point. Exit status: 0; 2 on bad input; 3 where "
    "tracks were written and failed."
)

# written here, since reading the table of pawnb.io.formats would slow every command down
_FORMATS = (
    "Formats: pawnb, movement, deeplabcut, collected, lightning-pose, sleap, anipose, dltdv-3d, "
    "dltdv, xmalab-3d, xmalab, argus-3d, argus, csv, csv-3d, table, nwb, c3d, locomouse, "
    "authors2019, and IN also trc, qtm, vicon, kinovea, tracker, manual-tracking, mtrackj, "
    "trackmate. "
    "A name of OUT that says its format needs no --to: tracks.nc, tracks.csv, ...3d.csv, "
    "...xypts.csv, ...xyzpts.csv, ...DLC....csv or .h5, CollectedData....csv or .h5, "
    "....analysis.h5, .slp, .nwb, .c3d."
)


class _Parser(argparse.ArgumentParser):
    """Says what is wrong in one sentence instead of printing the usage too."""

    def error(self, message: str) -> NoReturn:
        said = name_meant(message, self._option_string_actions)
        self.exit(EXIT_BAD_INPUT, f"{self.prog}: {said}; see {self.prog} --help.\n")

    def parse_known_args(  # type: ignore[override]
        self, args: Sequence[str] | None = None, namespace: argparse.Namespace | None = None
    ) -> tuple[argparse.Namespace, list[str]]:
        """Refuse what is unknown here: only the command itself knows which option was meant."""
        found, others = super().parse_known_args(args, namespace)
        if others:
            self.error(f"unrecognized arguments: {' '.join(others)}")
        return found, others


def build_parser() -> argparse.ArgumentParser:
    """Return the parser of all commands."""
    parser = _Parser(
        prog="pawnb",
        description="Video of a running animal to gait statistics.",
        epilog="-q (errors only), -v (where an error arose), --json: before or behind the command.",
    )
    parser.add_argument("--version", action="version", version=f"pawnb {pawnb.__version__}")
    parsers = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)
    _add_open(parsers)
    _add_new(parsers)
    _add_demo(parsers)
    _add_check(parsers)
    _add_track(parsers)
    _add_suggest(parsers)
    _add_batch(parsers)
    _add_gait(parsers)
    _add_evaluate(parsers)
    _add_compare(parsers)
    add_calibrate(parsers)
    _add_convert(parsers)
    _add_reproduce(parsers)
    _add_report(parsers)
    _add_selfcheck(parsers)
    _add_lab(parsers)
    _add_completion(parsers)
    add_shared_options(parsers.choices)
    return parser


def _add_open(parsers: Any) -> None:
    text = "the workbench in JupyterLab, on a folder, a trial or bare videos, on 127.0.0.1"
    command = parsers.add_parser("open", help=text, description=text)
    command.add_argument(
        "paths",
        nargs="*",
        metavar="PATH",
        help="a folder, a trial, or the videos of one recording (default: the current folder)",
    )
    command.add_argument("--no-browser", action="store_true", help="print the address only")
    command.add_argument("--port", type=int, help="default: a free one from 8888 on")
    command.set_defaults(run=commands.run_open)


def _add_new(parsers: Any) -> None:
    text = "make a trial.toml by questions; one that is there is never written over"
    command = parsers.add_parser("new", help=text, description=text)
    command.add_argument("videos", nargs="*", metavar="VIDEO", help="the video of each view")
    command.add_argument(
        "-o", "--out", help="folder of trial.toml (default: that of the first video)"
    )
    command.set_defaults(run=commands.run_new)


def _add_demo(parsers: Any) -> None:
    text = "render a synthetic trial with its truth, ready to track"
    command = parsers.add_parser("demo", help=text, description=text)
    command.add_argument(
        "scene",
        choices=["paws", "spider"],
        help="paws: a mouse on a treadmill; spider: a spider seen from above",
    )
    command.add_argument("-o", "--out", default=None, help="folder to write (default: demo-SCENE)")
    command.add_argument("--frames", type=int, default=120, help="how many (default: 120)")
    command.add_argument(
        "--scale",
        type=float,
        default=0.5,
        help="1 is 2048 x 700 px a view, of the spider 1280 x 1024 px (default: 0.5)",
    )
    command.add_argument("--seed", type=int, default=0, help="another animal (default: 0)")
    said = "; ".join(f"{name}: {what}" for name, what in VARIANTS.items())
    command.add_argument(
        "--vary",
        default="",
        metavar="NAME[,NAME...]",
        help=f"of paws, how the recording differs from a good one. {said}",
    )
    command.set_defaults(run=commands.run_demo)


def _add_check(parsers: Any) -> None:
    text = "say what a trial has, what is missing, and what looks wrong"
    command = parsers.add_parser("check", help=text, description=text)
    command.add_argument("trial", help="trial.toml, or the folder that holds it")
    command.set_defaults(run=commands.run_check)


def _add_track(parsers: Any) -> None:
    text = "track the points, or the pose, of a trial"
    command = parsers.add_parser("track", help=text, description=text, epilog=_VERDICT)
    command.add_argument("trial", help="trial.toml, or the folder that holds it")
    command.add_argument("-o", "--out", help="folder to write (default: results beside the trial)")
    command.add_argument(
        "--method",
        default=None,
        help="pawnb (default); paper: the published method (paws 2019, poses 2009); slic-3d, "
        "slic-2d: lesser variants of that of paws",
    )
    command.add_argument(
        "--set", action="append", default=[], metavar="NAME=VALUE", help="a setting of the tracker"
    )
    command.set_defaults(run=commands.run_track)


def _add_suggest(parsers: Any) -> None:
    text = "name the frames of a tracked trial in which further clicks would help most"
    more = f"{text}; gain is the number of labels that are expected to become right"
    command = parsers.add_parser("suggest", help=text, description=more)
    command.add_argument("trial", help="trial.toml, or the folder that holds it")
    command.add_argument(
        "--results", help="folder with its tracks (default: results beside the trial)"
    )
    command.add_argument("-n", type=int, default=3, help="frames at most (default: %(default)s)")
    command.add_argument("--json", action="store_true", help="print a JSON list instead")
    command.set_defaults(run=commands.run_suggest)


def _add_batch(parsers: Any) -> None:
    text = "track many trials, one process each; run again, it goes on where it stopped"
    command = parsers.add_parser("batch", help=text, description=text, epilog=_VERDICT)
    command.add_argument(
        "trials",
        nargs="+",
        metavar="TRIAL",
        help="trials, or folders of trials, such as one an animal",
    )
    where = command.add_mutually_exclusive_group()
    where.add_argument("--workers", type=int, help="trials at once on this machine (default: 1)")
    where.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="track on the workers of a Dask scheduler instead, such as tcp://cluster:8786",
    )
    command.add_argument(
        "-o",
        "--out",
        help="folder for a folder of results each (default: results beside each trial)",
    )
    command.add_argument("--method", help="as for pawnb track")
    command.add_argument(
        "--set", action="append", default=[], metavar="NAME=VALUE", help="a setting of the tracker"
    )
    command.set_defaults(run=commands.run_batch)


def _add_gait(parsers: Any) -> None:
    text = "events, strides, phases and figures; several inputs are pooled by animal"
    command = parsers.add_parser("gait", help=text, description=text)
    command.add_argument(
        "inputs",
        nargs="+",
        metavar="TRIAL|RESULTS|TRACKS|EVENTS|STUDY",
        help="a trial, its results folder, a tracks file, an events.csv scored by hand, or a "
        "study.toml or csv that names trials, animals, groups and covariates",
    )
    command.add_argument(
        "-o", "--out", help="folder to write (default: results by a trial, a tracks file's folder)"
    )
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
        "--groups",
        nargs="+",
        metavar="GROUP",
        help="group of each input's animals, in their order, to compare",
    )
    command.add_argument(
        "--event-names",
        nargs="+",
        metavar="NAME=EVENT",
        help="what a table of events calls them, as down=TD up=LO",
    )
    command.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="a setting of the analysis, as min_stance_s=0.02 or \"pairs=[['FL','FR']]\"",
    )
    command.add_argument(
        "--figures",
        choices=["all", "main", "none"],
        default="all",
        help="which figures to draw (default: all that the tables allow)",
    )
    command.set_defaults(run=commands.run_gait)


def _add_evaluate(parsers: Any) -> None:
    text = "errors of results against truth, or against tracks made by hand"
    more = f"{text}; without TRUTH, how steady poses are: --still (a) or --directions (b)"
    command = parsers.add_parser("evaluate", help=text, description=more)
    command.add_argument(
        "results", metavar="RESULTS", help="folder of results, or a tracks.nc; a trial for (b)"
    )
    command.add_argument(
        "truth",
        metavar="TRUTH",
        nargs="?",
        help="folder with pose.csv or tracks.csv, or one of these files",
    )
    command.add_argument(
        "--still",
        nargs=2,
        type=int,
        metavar=("FIRST", "LAST"),
        help="(a) how much the pose varies over frames in which the animal keeps still",
    )
    command.add_argument(
        "--directions",
        action="store_true",
        help="(b) track a trial forwards and in reverse, and compare the poses",
    )
    command.add_argument(
        "--disturb",
        nargs=2,
        type=float,
        metavar=("PX", "DEG"),
        help="for (b): standard deviation of what is added to each start pose",
    )
    command.add_argument("--method", help="for (b): method of the tracker (default: pawnb)")
    command.add_argument(
        "--threshold",
        type=float,
        metavar="PX",
        help="points further off than this are wrong (default: 20 in pictures 2048 px wide, in "
        "others in proportion)",
    )
    command.add_argument("-o", "--out", help="folder to write the tables to")
    command.set_defaults(run=commands.run_evaluate)


def _add_compare(parsers: Any) -> None:
    text = "compare methods of the tracker on trials with truth; of paws as the 2019 paper does"
    command = parsers.add_parser("compare", help=text, description=text)
    command.add_argument(
        "trials", nargs="+", metavar="TRIAL", help="trial with its truth/ beside it"
    )
    command.add_argument("--methods", help="names with commas between (default: all)")
    command.add_argument(
        "-o", "--out", default="comparison", help="folder to write (default: %(default)s)"
    )
    command.add_argument("--frames", type=int, help="track only so many frames of each trial")
    command.add_argument(
        "--no-corrections",
        action="store_true",
        help="of paws: do not count with corrections, which tracks again after each",
    )
    command.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="[METHOD.]NAME=VALUE",
        help="a setting of every method that has it, or of one, as paper.n_superpixels=150",
    )
    command.set_defaults(run=commands.run_compare)


def _add_convert(parsers: Any) -> None:
    text = "tracks of one program to those of another, both ways"
    command = parsers.add_parser("convert", help=text, description=text, epilog=_FORMATS)
    command.add_argument(
        "source",
        metavar="IN",
        help="tracks of any program below, or a trial: what it names, or what pawnb tracked",
    )
    command.add_argument(
        "target",
        metavar="OUT",
        help="the file; of several views, a format of one view writes NAME_VIEW",
    )
    command.add_argument(
        "--to", metavar="FORMAT", help="format of OUT (default: what its name says)"
    )
    command.add_argument(
        "--from", dest="program", metavar="FORMAT", help="format of IN (default: as it looks)"
    )
    command.add_argument("--fps", type=float, help="frame rate, where the input does not say")
    command.add_argument("--unit", help="unit of 3D points, where the input does not say")
    command.add_argument("--view", help="write this view only")
    command.add_argument("--animal", help="write this animal only")
    command.add_argument(
        "--legs",
        nargs="+",
        metavar="LEG=POINT",
        help="call these points as the legs they are, as HR=hindpaw_R",
    )
    command.add_argument(
        "--heights",
        type=int,
        nargs="+",
        metavar="PX",
        help="heights of the pictures, for Argus and DLTdv 7, which count upwards",
    )
    command.set_defaults(run=commands.run_convert)


def _add_reproduce(parsers: Any) -> None:
    text = "make a figure or a table again from what it carries, and say whether it is the same"
    more = "Exit status: 0 identical; 2 an input has changed or is missing; 3 it differs."
    command = parsers.add_parser("reproduce", help=text, description=text, epilog=more)
    command.add_argument(
        "files", nargs="+", metavar="FILE",
        help="a figure, a file of a folder of results, or such a folder: all that is in it",
    )  # fmt: skip
    command.add_argument(
        "--inputs",
        metavar="FOLDER",
        help="where its inputs are (default: the folder of FILE, and those it lies in)",
    )
    command.set_defaults(run=commands.run_reproduce)


def _add_report(parsers: Any) -> None:
    text = "one page on an animal or a study: methods, tables, figures, notes, in one file"
    command = parsers.add_parser("report", help=text, description=text)
    command.add_argument(
        "inputs", nargs="+", metavar="ANIMAL|STUDY", help="a study, or inputs as of pawnb gait"
    )
    command.add_argument("-o", "--out", metavar="FILE", help="default: report.html")
    command.add_argument("--fps", type=float, help="frame rate, where the input does not say")
    command.add_argument("--legs", nargs="+", metavar="LEG[=POINT]", help="as for pawnb gait")
    command.add_argument(
        "--set", action="append", default=[], metavar="NAME=VALUE", help="as for pawnb gait"
    )
    command.set_defaults(run=commands.run_report)


def _add_selfcheck(parsers: Any) -> None:
    text = "check this installation: published values, and a rendered trial of each kind"
    more = "Exit status: 0 where all came out as expected, else 3."
    command = parsers.add_parser("selfcheck", help=text, description=text, epilog=more)
    command.add_argument("--values-only", action="store_true", help="no trials; takes a second")
    command.set_defaults(run=commands.run_selfcheck)


def _add_completion(parsers: Any) -> None:
    text = "print what makes a shell complete commands and options"
    more = 'bash: eval "$(pawnb completion bash)" in ~/.bashrc; zsh alike; fish: | source'
    command = parsers.add_parser("completion", help=text, description=text, epilog=more)
    command.add_argument("shell", choices=SHELLS)
    command.set_defaults(
        run=lambda options, _argv: print(completion_script(options.shell, parsers.choices), end="")
    )


def _add_lab(parsers: Any) -> None:
    text = "open JupyterLab on the notebooks, on 127.0.0.1"
    command = parsers.add_parser("lab", help=text, description=text)
    command.add_argument("notebook", nargs="?", help="default: 00_quickstart.ipynb")
    command.add_argument("--no-browser", action="store_true", help="print the address only")
    command.add_argument("--port", type=int, help="default: a free one from 8888 on")
    command.set_defaults(run=commands.run_lab)
