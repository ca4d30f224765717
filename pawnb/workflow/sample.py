"""The built-in sample: a synthetic trial, rendered when it is first used."""

from __future__ import annotations

from pathlib import Path

from pawnb.synthetic import render_mouse_trial
from pawnb.trial import Trial, load_trial
from pawnb.workflow.progress import Progress, progress_bar

SAMPLE_FRAMES = 200
SAMPLE_SCALE = 0.5


def sample_trial(
    folder: str | Path = "sample/paws",
    *,
    frames: int = SAMPLE_FRAMES,
    scale: float = SAMPLE_SCALE,
    seed: int = 0,
    progress: Progress | None = None,
) -> Trial:
    """Return the sample trial; render it first where ``folder`` does not hold it yet.

    Parameters
    ----------
    folder : str or Path
        Where the sample is kept.
    frames : int
        How many frames to render.
    scale : float
        1 is 2048 x 700 px a view.
    seed : int
        Another seed is another animal.
    progress : callable, optional
        ``progress(done, total)``; default a bar on a terminal or in a notebook.

    Returns
    -------
    Trial
        A mouse on a treadmill seen by four cameras, with its truth in ``truth/``.
    """
    folder = Path(folder)
    # trial.toml is the last file that rendering writes: without it the sample is not whole
    if not (folder / "trial.toml").exists():
        with progress_bar("rendering the sample") as bar:
            render_mouse_trial(
                folder, frames=frames, scale=scale, seed=seed, progress=progress or bar
            )
    return load_trial(folder)
