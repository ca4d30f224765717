"""Open JupyterLab on the notebooks."""

from __future__ import annotations

import contextlib
import os
import shutil
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator, Sequence
from pathlib import Path

from pawnb.errors import InputError

QUICKSTART = "00_quickstart.ipynb"
_PACKAGE = Path(__file__).resolve().parents[1]
_CONFIG = Path(__file__).resolve().parent / "jupyter"


def notebooks_folder() -> Path:
    """Return the folder of the notebooks that belong to this pawnb.

    Returns
    -------
    Path
        ``notebooks`` of the checkout; for an installed package, ``pawnb-notebooks`` in
        the current folder, into which those that are not there yet are copied, so
        that an update never overwrites what somebody changed.
    """
    checkout = _PACKAGE.parent / "notebooks"
    if (checkout / QUICKSTART).exists():
        return checkout
    own = Path.cwd() / "pawnb-notebooks"
    own.mkdir(exist_ok=True)
    for notebook in sorted((_PACKAGE / "notebooks").glob("*.ipynb")):
        if not (own / notebook.name).exists():
            shutil.copy(notebook, own / notebook.name)
    return own


def lab_command(
    notebook: str | Path | None = None, *, browser: bool = True, port: int | None = None
) -> list[str]:
    """Return the command that starts JupyterLab on a notebook.

    Parameters
    ----------
    notebook : str or Path, optional
        A notebook, or the name of one of ours; default the quick start.
    browser : bool
        Whether to open a browser.
    port : int, optional
        Port on 127.0.0.1.

    Returns
    -------
    list of str
        The words of the command; it runs in the Python that runs pawnb.

    Raises
    ------
    InputError
        If there is no such notebook, or no such port.
    """
    folder = notebooks_folder()
    name = QUICKSTART if notebook is None else str(notebook)
    path = next((p for p in (Path(name), folder / name) if p.is_file()), None)
    if path is None:
        ours = ", ".join(p.name for p in sorted(folder.glob("*.ipynb")))
        raise InputError(f"{name}: no such notebook; ours are {ours}.")
    path = path.resolve()
    words = [sys.executable, "-m", "jupyter", "lab", "--ip=127.0.0.1"]
    # the address that is printed leads to the notebook too, not only the browser that is opened
    words += [f"--ServerApp.root_dir={path.parent}", f"--LabApp.default_url=/lab/tree/{path.name}"]
    if not browser:
        words.append("--no-browser")
    if port is not None:
        if not 0 < port < 65536:
            raise InputError(f"port is {port}; expected 1 to 65535.")
        words.append(f"--port={port}")
    if hasattr(os, "geteuid") and os.geteuid() == 0:
        # containers run as root; the server listens on this machine only
        words.append("--allow-root")
    return words


def lab_environment() -> dict[str, str]:
    """Return the environment that JupyterLab is started in.

    Returns
    -------
    dict of str to str
        That of this process, with our own settings of JupyterLab before those of the machine,
        and none of them written anywhere.
    """
    given = os.environ.get("JUPYTER_CONFIG_PATH")
    paths = [str(_CONFIG), *([given] if given else [])]
    return {
        **os.environ,
        # no question about news from the network over the notebook's corner
        "JUPYTER_CONFIG_PATH": os.pathsep.join(paths),
        # a kernel of another environment that is called python3 must not be taken for ours
        "JUPYTER_PREFER_ENV_PATH": "1",
    }


def open_lab(
    notebook: str | Path | None = None, *, browser: bool = True, port: int | None = None
) -> None:
    """Run JupyterLab until it is stopped.

    Parameters
    ----------
    notebook, browser, port
        As for :func:`lab_command`.

    Raises
    ------
    InputError
        If there is no such notebook, or JupyterLab could not start.
    """
    run_lab(lab_command(notebook, browser=browser, port=port))


def run_lab(words: Sequence[str]) -> None:
    """Run a command of :func:`lab_command` until it is stopped.

    Raises
    ------
    InputError
        If JupyterLab could not start.
    """
    with subprocess.Popen(words, env=lab_environment()) as server, _ended_with_us(server):
        status = server.wait()
    if status not in (0, -signal.SIGINT, -signal.SIGTERM):
        raise InputError(f"JupyterLab ended with status {status}; its message above says why.")


@contextlib.contextmanager
def _ended_with_us(server: subprocess.Popen[bytes]) -> Iterator[None]:
    """End a server when this process is asked to end: else it would go on without a terminal."""
    if threading.current_thread() is not threading.main_thread():
        yield  # only the main thread hears signals
        return
    before = signal.signal(signal.SIGTERM, lambda *_: server.terminate())
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)
