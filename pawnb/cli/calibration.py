"""``pawnb calibrate``: its options, and what it prints."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from pawnb.cli.shared import print_json
from pawnb.errors import InputError

EXIT_DISAGREES = 3
_HELP = "cameras from a board, a wand or clicked points, or from another program's calibration"
_MORE = (
    f"{_HELP}. --board BOARD.toml VIEW=PICTURES ...: a checkerboard or ChArUco board shown to all "
    "views; PICTURES is a video, a folder or a glob; pictures of one number are of one instant. "
    "--wand LENGTH ENDS.csv: a wand that was tracked in all views (frame, view, point, u, v). "
    "POINTS3D CLICKS: a csv with point, x, y, z and a csv with view, point, u, v. FILE: cameras of "
    "Anipose, Pose2Sim or caliscope (.toml), OpenCV (.yaml), XMALab (MayaCam 2.0, one a camera), "
    "or DLT coefficients (--from). Written are DLTcoefs.csv and, where a lens bends, lenses.toml; "
    "or, of a FILE, a calibration for another program (--to). Exit status: 0; 2 on bad input; 3 "
    "where views of a board do not agree, or --judge finds a camera that does not belong."
)

_TARGETS = (
    "anipose", "opencv", "mayacam", "dltdv", "dltdv7", "easywand", "argus", "xmalab", "pawnb",
)  # fmt: skip


def add_calibrate(parsers: Any) -> None:
    """Add the command to those of ``pawnb``."""
    command = parsers.add_parser("calibrate", help=_HELP, description=_MORE)
    command.add_argument(
        "files",
        nargs="+",
        metavar="VIEW=PICTURES | ENDS | POINTS3D CLICKS | FILE",
        help="see above",
    )
    command.add_argument(
        "-o", "--out", metavar="FILE", help="default: DLTcoefs.csv; needed with --to"
    )
    command.add_argument(
        "--views", nargs="+", metavar="VIEW",
        help="order of the views, which is that of the trial (default: as they are given)",
    )  # fmt: skip
    board = command.add_argument_group("from a board")
    board.add_argument(
        "--board", metavar="BOARD.toml", help="board_x, board_y, square_length, marker_length, ..."
    )
    board.add_argument(
        "--floor", type=int, metavar="N",
        help="picture (from 0) in which the board lies on the floor: it gives the axes (default: "
        "the first that most views see)",
    )  # fmt: skip
    board.add_argument(
        "--shots", type=int, default=100, metavar="N",
        help="of longer films so many frames are looked at (default: %(default)s)",
    )  # fmt: skip
    board.add_argument(
        "--judge", metavar="FILE",
        help="write nothing: tell how well the cameras of FILE show the board, and which do not",
    )  # fmt: skip
    wand = command.add_argument_group("from a wand")
    wand.add_argument(
        "--wand", type=float, metavar="LENGTH",
        help="distance of its two ends, in the unit that the calibration will have",
    )  # fmt: skip
    wand.add_argument(
        "--size", nargs="+", metavar="WIDTHxHEIGHT", default=[],
        help="of the pictures, px: one for all views, or one a view, as 1280x1024",
    )  # fmt: skip
    wand.add_argument(
        "--lenses", metavar="LENSES.toml",
        help="lenses that are known, for instance from a board; without it focal lengths are found "
        "and nothing is taken to bend",
    )  # fmt: skip
    file = command.add_argument_group("from another program")
    file.add_argument(
        "--from", dest="program", metavar="PROGRAM",
        help="whose DLT coefficients FILE holds: dltdv (8), dltdv7, easywand, argus, xmalab, pawnb",
    )  # fmt: skip
    file.add_argument(
        "--to", metavar="PROGRAM", choices=_TARGETS,
        help=f"write for another program: {', '.join(_TARGETS)} (mayacam is XMALab's file of a "
        "camera: name a folder with -o)",
    )  # fmt: skip
    file.add_argument(
        "--heights", type=int, nargs="+", metavar="PX",
        help="heights of the pictures, for coefficients of DLTdv 7, easyWand, XMALab and Argus",
    )  # fmt: skip
    command.set_defaults(run=run_calibrate)


def run_calibrate(options: argparse.Namespace, _argv: list[str]) -> int:
    """Calibrate by what is given, and say how well."""
    from pawnb.workflow.calibration.calibrate import is_points

    if options.to is not None and (options.board or options.wand or is_points(options.files[0])):
        raise InputError("--to takes a FILE: calibrate first, then write it for another program.")
    if options.to is not None:
        return _for_program(options)
    options.out = options.out or "DLTcoefs.csv"
    _refuse_unused(options)
    if options.board is not None:
        return _by_board(options)
    for name in ("judge", "floor"):
        if getattr(options, name) is not None:
            raise InputError(f"--{name} needs the board that was filmed: --board BOARD.toml.")
    if options.wand is not None:
        return _by_wand(options)
    if is_points(options.files[0]):
        return _by_points(options)
    return _by_file(options)


def _refuse_unused(options: argparse.Namespace) -> None:
    """Refuse options of another way to calibrate, which would change nothing."""
    from pawnb.workflow.calibration.calibrate import is_points

    by_points = options.board is None and options.wand is None and is_points(options.files[0])
    if options.board is not None and options.wand is not None:
        raise InputError("--board and --wand are two ways to calibrate; give one of them.")
    if options.wand is None and (options.lenses or options.size):
        name = "lenses" if options.lenses else "size"
        more = (
            "; where lenses bend, click points with CalibrationDigitiser and choose 'Lenses bend', "
            "or film a board" if by_points and options.lenses else ""
        )  # fmt: skip
        raise InputError(f"--{name} is for a wand (--wand) and would not be heeded here{more}.")
    if (options.program or options.heights) and (by_points or options.board or options.wand):
        name = "from" if options.program else "heights"
        raise InputError(
            f"--{name} is for DLT coefficients of another program and would not be heeded here; "
            "clicks and pictures are in pixels from the centre of the top-left one, v downwards."
        )


def _by_board(options: argparse.Namespace) -> int:
    """Calibrate, or judge cameras, by pictures of a board."""
    from pawnb.workflow.calibration.board import calibrate_from_board, judge_cameras
    from pawnb.workflow.progress import progress_bar

    pictures = _pictures(options.files, options.views)
    with progress_bar("finding the board", unit="picture") as progress:
        if options.judge is not None:
            found = judge_cameras(
                options.judge, options.board, pictures, most_shots=options.shots, progress=progress
            )
        else:
            found = calibrate_from_board(
                options.board,
                pictures,
                out=options.out,
                floor=options.floor,
                most_shots=options.shots,
                progress=progress,
            )
    if options.json:
        print_json(**found.table())
    else:
        print(found.text())
    return 0 if found.is_sound else EXIT_DISAGREES


def _by_wand(options: argparse.Namespace) -> int:
    """Calibrate by a wand that was tracked."""
    from pawnb.workflow.calibration.wand import calibrate_from_wand

    if len(options.files) != 1 or not options.size:
        raise InputError(
            "--wand needs one csv of its two ends (frame, view, point, u, v) and the size of the "
            "pictures, for instance --size 1280x1024."
        )
    found = calibrate_from_wand(
        options.files[0],
        options.wand,
        sizes=[_size(word) for word in options.size],
        out=options.out,
        views=options.views,
        lenses=options.lenses,
    )
    if options.json:
        print_json(**found.table())
    else:
        print(found.text())
    return 0


def _size(word: str) -> tuple[int, int]:
    """Return width and height from WIDTHxHEIGHT."""
    width, x, height = word.lower().partition("x")
    if not (x and width.isdigit() and height.isdigit() and int(width) and int(height)):
        raise InputError(f"--size {word}: expected WIDTHxHEIGHT, for instance 1280x1024.")
    return int(width), int(height)


def _by_points(options: argparse.Namespace) -> int:
    """Calibrate by points of known position."""
    from pawnb.workflow.calibration.calibrate import calibrate

    first, *others = options.files
    if len(others) != 1:
        raise InputError(f"{first} holds known points; name the csv of their clicks after it.")
    fit = calibrate(first, others[0], out=options.out, views=options.views)
    if options.json:
        print_json(
            views=list(fit.rig.names), clicks=fit.residuals, remarks=list(fit.remarks),
            files=[options.out],
        )  # fmt: skip
    else:
        print(fit.text())
        print(
            f"wrote {options.out}; name it in trial.toml, its views in the order "
            f"{', '.join(fit.rig.names)}: [calibration] dlt = ..."
        )
    return 0


def _by_file(options: argparse.Namespace) -> int:
    """Take over another program's calibration."""
    from pawnb.workflow.calibration.calibrate_file import calibrate_from_file

    taken = calibrate_from_file(
        *options.files,
        out=options.out,
        program=options.program,
        views=options.views,
        heights_px=options.heights,
    )
    if options.json:
        print_json(
            views=list(taken.views), origin=taken.origin.tolist(), remarks=list(taken.remarks),
            files=taken.files(),
        )  # fmt: skip
    else:
        print(taken.text())
    return 0


def _for_program(options: argparse.Namespace) -> int:
    """Write a calibration as another program reads it."""
    from pawnb.workflow.calibration.export_file import export_calibration

    if options.out is None:
        raise InputError(f"--to {options.to}: name the file to write with -o.")
    done = export_calibration(
        *options.files,
        out=options.out,
        to=options.to,
        program=options.program,
        views=options.views,
        heights_px=options.heights,
    )
    if options.json:
        files = [str(path) for path in done.paths]
        print_json(views=list(done.views), origin=done.origin.tolist(), files=files)
    else:
        print(done.text())
    return 0


def _pictures(words: list[str], order: list[str] | None) -> dict[str, str]:
    """Return the pictures of each view, from VIEW=PICTURES or from names of folders and files."""
    found: dict[str, str] = {}
    for word in words:
        name, equals, path = word.partition("=")
        if not equals or Path(word).exists():
            name, path = Path(word).stem, word
        if not name or not path:
            raise InputError(f"{word}: expected VIEW=PICTURES, for instance side=board/side.")
        if name in found:
            raise InputError(
                f"two views are called {name!r} ({found[name]} and {path}); name them as "
                "VIEW=PICTURES."
            )
        found[name] = path
    if order is None:
        return found
    if sorted(order) != sorted(found):
        raise InputError(
            f"views {', '.join(order)} are named, but there are pictures of {', '.join(found)}; "
            "name each of these once."
        )
    return {name: found[name] for name in order}
