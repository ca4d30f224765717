"""Programs without a library, run from their own sources: Argus, DLTdv 7. See ``formats.py``.

Argus comes from the package index (``pip install --no-deps --target FOLDER argus_gui``); DLTdv 7 is
``DLTdv7.m`` of github.com/tlhedrick/dltdv and runs in Octave. Both are looked for in
``$PAWNB_PEER_PROGRAMS``, folders ``argus`` and ``dltdv``. Of their windows nothing is run: the
lines that write and read files are taken out of the sources as they are, with their variables.
"""

from __future__ import annotations

import ast
import io
import os
import shutil
import subprocess
import sys
import textwrap
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import cv2
import numpy as np
import pandas as pd
import scipy.io
import scipy.sparse

NAMES = ("Track 1", "Track 2", "Track 3", "Track 4")


class NoProgramError(ModuleNotFoundError):
    """A program that is not here, by its name."""

    def __init__(self, name: str) -> None:
        super().__init__(f"no {name}", name=name)


def _source(folder: str, name: str) -> Path:
    """Return a file of a program's source."""
    found = sorted(Path(os.environ.get("PAWNB_PEER_PROGRAMS", "-"), folder).rglob(name))
    if not found:
        raise NoProgramError(name)
    return found[0]


# --- Argus ----------------------------------------------------------------------------------------


class _OldFrame(pd.DataFrame):
    """Argus was written for pandas before 1.0."""

    def as_matrix(self) -> np.ndarray:
        return self.to_numpy()


def _argus(names: tuple[str, ...], given: dict[str, Any]) -> dict[str, Any]:
    """Return functions of Argus' clicker, also those of its window, without opening one."""
    trees = [ast.parse(_source("argus", name).read_text(encoding="utf-8"))
             for name in ("argus-click", "tools.py")]  # fmt: skip
    found = [node for tree in trees for node in ast.walk(tree)
             if isinstance(node, ast.FunctionDef) and node.name in names]  # fmt: skip
    code = compile(ast.Module(body=found, type_ignores=[]), "argus-click", "exec")

    def read_csv(*args: Any, **more: Any) -> _OldFrame:
        return _OldFrame(pd.read_csv(*args, **more))

    silent = SimpleNamespace(showinfo=lambda *_: None, showwarning=_complain)
    values = {
        "pandas": SimpleNamespace(DataFrame=_OldFrame, read_csv=read_csv),
        "np": np, "sys": SimpleNamespace(platform="darwin", stdout=io.StringIO()),
        "six": SimpleNamespace(moves=SimpleNamespace(tkinter_messagebox=silent)),
        "csc_matrix": lambda values: scipy.sparse.csc_matrix(np.asarray(values, float)),
        "ghostWindow": type(None), "ArgusError": ValueError, "range": range, **given,
    }  # fmt: skip
    exec(code, values)  # noqa: S102 - their program is what is tried
    return values


def _complain(*words: str) -> None:
    raise ValueError(" ".join(words))


def argus_writes(
    place: np.ndarray, prefix: Path, coefs: np.ndarray | None = None
) -> tuple[Path, np.ndarray | None]:
    """Let Argus write points in the views, and those in space that it makes of them.

    Parameters
    ----------
    place : ndarray, shape (n_frames, n_points, n_cameras, 2)
        Points as Argus counts them, v upwards.
    prefix : Path
        What the files begin with.
    coefs : ndarray, shape (n_cameras, 11), optional
        DLT coefficients, for points in space.

    Returns
    -------
    tuple
        Its ``-xypts.csv``, and with coefficients the points (n_frames, n_points, 3) that it found
        and wrote as ``-xyzpts.csv``.
    """
    n_frames, n_points, n_cameras, _ = place.shape
    common = {
        f"{NAMES[k]}_cam_{c + 1}_{axis}": place[:, k, c, i]
        for k in range(n_points)
        for c in range(n_cameras)
        for i, axis in enumerate("xy")
    }
    windows = [
        SimpleNamespace(fillCommonDictionary=lambda: None, offsets_output=np.zeros(n_frames))
        for _ in range(n_cameras)
    ]
    straight = [np.array([900.0, 320.0, 240.0, 0.0, 0.0, 0.0, 0.0, 0.0])] * n_cameras
    values = _argus(
        ("saveNonSparse", "uv_to_xyz", "get_repo_errors", "undistort_pts", "reconstruct_uv"),
        {"common": common, "fnam": str(prefix), "trackList": list(NAMES[:n_points]),
         "pyglet": SimpleNamespace(app=SimpleNamespace(windows=windows)), "tkFileDialog": None,
         "bstrap": False, "cv2": cv2, "DLTCoefficients": coefs,
         "CameraProfile": None if coefs is None else straight},
    )  # fmt: skip
    values["saveNonSparse"](SimpleNamespace(end=n_frames), saveas=False)
    found = None
    if coefs is not None:
        found = np.stack(
            [values["uv_to_xyz"](place[:, k].reshape(n_frames, -1), straight, coefs)
             for k in range(n_points)], axis=1,
        )  # fmt: skip
    return Path(f"{prefix}-xypts.csv"), found


def argus_reads(path: Path, n_cameras: int) -> dict[str, np.ndarray]:
    """Return what Argus shows of a table: by the name of each track (frames, cameras, 2)."""
    windows = [object()] * n_cameras
    values = _argus(
        ("loadCSV", "loadPoints"),
        {"pyglet": SimpleNamespace(app=SimpleNamespace(windows=windows)),
         "time": SimpleNamespace(clock=lambda: 0.0)},
    )  # fmt: skip
    values["loadCSV"](str(path))
    shown: dict[str, list[np.ndarray]] = {}
    for n in range(1, n_cameras + 1):
        window = SimpleNamespace(
            points=dict.fromkeys(values["trackList"]), n=n, end=10**6,
            clearBatch=lambda: None, drawTracks=lambda: None,
        )  # fmt: skip
        values["loadPoints"](window)
        for name, points in window.points.items():
            full = points.toarray()
            full[full == 0] = np.nan
            shown.setdefault(name, []).append(full)
    return {name: np.stack(parts, axis=1) for name, parts in shown.items()}


def argus_writes_coefficients(coefs: np.ndarray, prefix: Path) -> Path:
    """Let Argus write DLT coefficients (11,) of one camera."""
    tree = ast.parse(_source("argus", "graphers.py").read_text(encoding="utf-8"))
    found = [node for node in ast.walk(tree)
             if isinstance(node, ast.FunctionDef) and node.name == "outputDLT"]  # fmt: skip
    values: dict[str, Any] = {"np": np, "pandas": pd, "print": lambda *_: None,
                              "sys": SimpleNamespace(stdout=io.StringIO())}  # fmt: skip
    exec(compile(ast.Module(body=found, type_ignores=[]), "graphers.py", "exec"), values)  # noqa: S102
    values["outputDLT"](SimpleNamespace(name=str(prefix), order=None), [coefs[:, None]], [0.0])
    return Path(f"{prefix}-dlt-coefficients.csv")


def argus_shows(path: Path, xyz: np.ndarray) -> np.ndarray:
    """Return where Argus shows points (n, 3) after it loaded coefficients of one camera."""
    values = _argus(
        ("loadDLT", "dlt_inverse"),
        {"tkFileDialog": SimpleNamespace(askopenfilename=lambda **_: str(path))},
    )
    values["loadDLT"](SimpleNamespace(dlt=SimpleNamespace(set=lambda _: None)))
    return np.asarray(values["dlt_inverse"](values["DLTCoefficients"], xyz))


# --- DLTdv 7, in Octave ---------------------------------------------------------------------------


def _octave() -> str:
    found = shutil.which("octave-cli")
    if found is None:
        raise NoProgramError("octave-cli")
    return found


def _between(text: str, first: str, last: str) -> str:
    """Return the lines from one that has some words to before one that has others."""
    start = text.index(first)
    return text[start : text.index(last, start)]


def _run(folder: Path, script: str) -> None:
    """Run lines of DLTdv 7 in Octave, with its functions for files beside them."""
    source = _source("dltdv", "DLTdv7.m").read_text(encoding="utf-8", errors="replace")
    for name in ("sp2full", "full2sp", "sparseRead", "sparseSave"):
        start = source.index("function", source.index(f"%% {name}\n"))
        end = source.find("\n%%", start)
        (folder / f"{name}.m").write_text(source[start : end if end > 0 else None])
    (folder / "run.m").write_text(script)
    done = subprocess.run(
        [_octave(), "--quiet", "--no-gui", "run.m"], cwd=folder, capture_output=True, text=True,
        check=False,
    )  # fmt: skip
    if done.returncode:
        sys.exit(f"DLTdv 7 in Octave: {done.stderr.strip()}")


_WINDOWS = textwrap.dedent("""\
    1;
    function msgbox(varargin)
    end
    function setappdata(varargin)
    end
    h = 1;
""")


def _filled(values: np.ndarray) -> np.ndarray:
    return np.nan_to_num(np.asarray(values, dtype=float))


def dltdv7_writes(place: np.ndarray, xyz: np.ndarray, folder: Path, *, sparse: bool) -> Path:
    """Let DLTdv 7 write points; returns its file of the views.

    Parameters
    ----------
    place : ndarray, shape (n_frames, n_points, n_cameras, 2)
        In the pixels of DLTdv 7, NaN where not digitised.
    xyz : ndarray, shape (n_frames, n_points, 3)
        In space.
    folder : Path
        Where to.
    sparse : bool
        As ``.tsv``.
    """
    n, n_points, n_views, _ = place.shape
    scipy.io.savemat(folder / "given.mat", {
        "xy": _filled(place.reshape(n, -1)), "xyz": _filled(xyz.reshape(n, -1)),
        "res": np.full((n, n_points), 0.5), "off": np.tile(np.arange(n_views) * 3.0, (n, 1)),
    })  # fmt: skip
    source = _source("dltdv", "DLTdv7.m").read_text(encoding="utf-8", errors="replace")
    lines = _between(source, "% start the actual data save routines", "%% case 6 - load")
    _run(folder, _WINDOWS + textwrap.dedent(f"""\
        load given.mat
        uda.xypts = sparse(xy); uda.dltpts = sparse(xyz); uda.dltres = sparse(res);
        uda.offset = sparse(off); uda.nvid = {n_views};
        pname = pwd; pfix = 'theirs_'; sType = '{"sparse" if sparse else "flat"}';
    """) + lines)  # fmt: skip
    return folder / f"theirs_xypts.{'tsv' if sparse else 'csv'}"


def dltdv7_reads(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Return the points in the views and in space that DLTdv 7 opens; NaN where there are none."""
    source = _source("dltdv", "DLTdv7.m").read_text(encoding="utf-8", errors="replace")
    lines = _between(source, "    if strcmpi(fname1(end-2:end),'csv')", "% check for similarity")
    prefix = path.name[: -len("xypts.csv")]
    _run(path.parent, _WINDOWS + textwrap.dedent(f"""\
        fname1 = '{path.name}'; pfix = [pwd, filesep, '{prefix}'];
    """) + lines + textwrap.dedent("""\
        xy = sp2full(uda.xypts); xyz = sp2full(uda.dltpts); n = numpts;
        assert(size(uda.offset, 1) == size(xy, 1));
        save('-v6', 'found.mat', 'xy', 'xyz', 'n');
    """))  # fmt: skip
    found = scipy.io.loadmat(path.parent / "found.mat")
    n = int(found["n"].item())
    xy, xyz = found["xy"], found["xyz"]
    return xy.reshape(len(xy), n, -1, 2), xyz.reshape(len(xyz), n, 3)
