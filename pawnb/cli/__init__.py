"""The commands of ``pawnb``, from ``demo`` and ``check`` to ``lab``.

Exit status 0 on success, 2 on bad input with one sentence on standard error, 3 where tracks were
written and most of them are expected to be wrong.
"""

from __future__ import annotations

import argparse
import contextlib
import sys
import traceback
from collections.abc import Sequence

from pawnb.cli.arguments import EXIT_BAD_INPUT, build_parser
from pawnb.cli.output import readers_may_leave
from pawnb.cli.shared import command_first, of_results
from pawnb.errors import InputWarning, PawnbError, QualityWarning
from pawnb.input_warnings import hearing_input_warnings

__all__ = ["EXIT_BAD_INPUT", "EXIT_INTERRUPTED", "main"]


def __dir__() -> list[str]:
    """List the public names."""
    return sorted(__all__)


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
        0 on success, 2 on bad input, 3 where tracking failed by its own verdict, 130 when
        interrupted.
    """
    words = list(sys.argv[1:] if argv is None else argv)
    with readers_may_leave():
        return _main(words)


def _main(words: list[str]) -> int:
    """Run one command and print the notes of it."""
    options = build_parser().parse_args(command_first(words))
    told: list[InputWarning] = []
    with hearing_input_warnings(told.append, shown=False):
        # JSON was asked for by name: -q leaves the notes away, and not it
        silent = options.quiet and not getattr(options, "json", False)
        with contextlib.redirect_stdout(None) if silent else contextlib.nullcontext():
            status = _run(options, ["pawnb", *of_results(words)])
    for warning in told:
        # of how good tracks are the command's own line tells
        if not (options.quiet or isinstance(warning, QualityWarning)):
            print(f"pawnb: note: {warning}", file=sys.stderr)
    return status


def _run(options: argparse.Namespace, argv: list[str]) -> int:
    """Run the chosen command and turn what it raises into an exit status."""
    try:
        status = options.run(options, argv)
    except PawnbError as error:
        if options.verbose:
            traceback.print_exc()
        print(f"pawnb: {error}", file=sys.stderr)
        return EXIT_BAD_INPUT
    except OSError as error:
        # a full disk, a folder that may not be written: neither a fault of pawnb nor its to mend
        reason = f"{error.filename}: {error.strerror}" if error.filename else str(error)
        print(f"pawnb: {reason}; choose another place, or mend this one.", file=sys.stderr)
        return EXIT_BAD_INPUT
    except KeyboardInterrupt:
        print("pawnb: interrupted", file=sys.stderr)
        return EXIT_INTERRUPTED
    return int(status or 0)
