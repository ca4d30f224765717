"""One trial of a batch, in a process of its own: ``python -m pawnb.workflow.batch.worker``.

The order is a line of JSON on standard input, the answer one on standard output. When standard
input is closed, or whoever gave the order dies, tracking stops and keeps what is done.
"""

from __future__ import annotations

import json
import os
import sys
import threading
from pathlib import Path
from typing import Any

from pawnb.errors import BusyError, InputWarning, PawnbError, QualityWarning
from pawnb.input_warnings import hearing_input_warnings
from pawnb.trial import load_trial
from pawnb.workflow.batch.renamed import describe_anew
from pawnb.workflow.batch.run import described_otherwise, tracked_already
from pawnb.workflow.provenance.manifest import find_fault, known_files, run_alone
from pawnb.workflow.provenance.results import make_folder
from pawnb.workflow.reviewing.quality import assess_quality, read_verdict
from pawnb.workflow.tracking.track import track

_NO_MEMORY = "the memory was too small for it: let fewer trials run at once"


def main() -> None:
    """Take one order, track, and answer."""
    order = json.loads(_read_line())
    stop = threading.Event()
    threading.Thread(target=_wait_for_end, args=(stop,), daemon=True).start()
    answer = _track(order, stop)
    sys.stdout.write(json.dumps(answer) + "\n")


def _track(order: dict[str, Any], stop: threading.Event) -> dict[str, str]:
    """Track the trial of an order; bad input becomes an answer, not an error."""
    asked = {"method": order["method"], "settings": order["settings"]}
    out = Path(order["out"])
    warned: list[InputWarning] = []
    with hearing_input_warnings(warned.append, shown=False):
        try:
            trial = load_trial(order["trial"])
            with run_alone(make_folder(out)):
                # another batch may have tracked it since this was ordered
                before = tracked_already(trial, out, **asked)
                if before is not None:
                    return before._asdict()
                if changed := described_otherwise(trial, out, **asked):
                    describe_anew(trial, out)
                    return _described(out, changed)
                tracks = track(
                    trial,
                    **asked,
                    out=out,
                    progress=lambda _done, _total: None,
                    stop=stop.is_set,
                    command=order["command"] or None,
                )
        except BusyError as error:
            return {"status": "busy", "said": str(error)}
        except PawnbError as error:
            return {"status": "failed", "said": str(error)}
        except MemoryError as error:
            return {"status": "failed", "said": f"{_NO_MEMORY} ({error or 'MemoryError'})"}
        except OSError as error:  # such as a full disk
            where = f"{error.filename}: " if error.filename else ""
            return {"status": "failed", "said": f"{where}{error.strerror or error}"}
    if stop.is_set() and not tracks.sizes["time"]:
        return {"status": "stopped", "said": "interrupted before the first frame was tracked"}
    notes = [str(one) for one in warned if not isinstance(one, QualityWarning)]
    quality = assess_quality(tracks)
    done = f"{tracks.sizes['time']} frames, {order['out']}"
    status = "stopped" if stop.is_set() else "tracked"
    return {
        "status": status,
        "said": "; ".join([done, quality.line(), *notes]),
        "verdict": quality.verdict,
    }


def _described(out: Path, changed: str) -> dict[str, str]:
    """Answer that results were described anew."""
    old_gait = find_fault(out, run="gait") if known_files(out).files_of("gait") else None
    said = f"tracked already, {out}; {changed} brought to what the trial says now"
    told = "; ".join([said, *([old_gait] if old_gait else [])])
    return {"status": "skipped", "said": told, "verdict": read_verdict(out)}


def _read_line() -> bytes:
    """Read standard input to the end of a line, and no further."""
    line = b""
    while not line.endswith(b"\n"):
        byte = os.read(sys.stdin.fileno(), 1)
        if not byte:
            break
        line += byte
    return line


def _wait_for_end(stop: threading.Event) -> None:
    """Wait until standard input is closed. Unbuffered, so that it never holds up the end."""
    while os.read(sys.stdin.fileno(), 1):
        pass
    stop.set()


if __name__ == "__main__":
    main()
