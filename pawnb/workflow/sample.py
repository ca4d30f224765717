"""The built-in samples: synthetic trials, rendered when they are first used."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from pawnb.errors import InputError
from pawnb.schema.arguments import checked_arguments
from pawnb.synthetic import render_mouse_trial, render_spider_trial
from pawnb.trial import Trial, load_trial
from pawnb.workflow.progress import Progress, progress_bar

SAMPLE_FRAMES = {"paws": 200, "spider": 120}
SAMPLE_SCALE = 0.5


@checked_arguments
def sample_trial(
    folder: str | Path | None = None,
    *,
    scene: Literal["paws", "spider"] = "paws",
    frames: int | None = None,
    scale: float = SAMPLE_SCALE,
    seed: int = 0,
    progress: Progress | None = None,
) -> Trial:
    """Return a sample trial; render it first where ``folder`` does not hold it yet.

    Parameters
    ----------
    folder : str or Path, optional
        Where the sample is kept; default ``sample/`` and the scene.
    scene : {"paws", "spider"}
        A mouse on a treadmill seen by four cameras, or a spider that runs over a light panel,
        seen from above.
    frames : int, optional
        How many frames to render; default 200 of the mouse, 120 of the spider.
    scale : float
        1 is 2048 x 700 px a view of the mouse, 1280 x 1024 px of the spider.
    seed : int
        Another seed is another animal.
    progress : callable, optional
        ``progress(done, total)``; default a bar on a terminal or in a notebook.

    Returns
    -------
    Trial
        The trial, with its truth in ``truth/``.

    Raises
    ------
    InputError
        For another scene, or a number that makes no sense.

    Examples
    --------
    >>> trial = pawnb.sample_trial("sample", frames=60, scale=0.2)
    >>> trial.kind
    'paws'
    """
    if scene not in SAMPLE_FRAMES:
        raise InputError(f"scene is {scene!r}; expected {' or '.join(SAMPLE_FRAMES)}.")
    folder = Path(folder or f"sample/{scene}")
    render = render_spider_trial if scene == "spider" else render_mouse_trial
    # trial.toml is the last file that rendering writes: without it the sample is not whole
    if not (folder / "trial.toml").exists():
        with progress_bar("rendering the sample") as bar:
            render(
                folder,
                frames=frames or SAMPLE_FRAMES[scene],
                scale=scale,
                seed=seed,
                progress=progress or bar,
            )
    return load_trial(folder)
