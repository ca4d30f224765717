"""BootsTAPIR, a network that follows any point of a video (Doersch et al. 2023, 2024).

It comes with the package ``tapnet`` on PyTorch. pawnb needs neither: both are imported here alone,
when a trial names the file with the network's weights.
"""

from __future__ import annotations

import functools
import importlib
from pathlib import Path
from typing import Any

import numpy as np

from pawnb.arrays import ByteArray, FloatArray
from pawnb.errors import InputError, InputWarning
from pawnb.input_warnings import warn_of_input

_INSTALL = (
    'python -m pip install "tapnet[torch] @ git+https://github.com/google-deepmind/tapnet.git"'
)
_WEIGHTS = "https://storage.googleapis.com/dm-tapnet/bootstap/bootstapir_checkpoint_v2.pt"
_MEND = "or leave [tracking] point_tracker out"


class Tapir:
    """The network with its weights, on the graphics card where torch finds one.

    Parameters
    ----------
    torch : module
        PyTorch.
    network : torch.nn.Module
        What :func:`load_tapir` makes.
    """

    def __init__(self, torch: Any, network: Any) -> None:
        self._torch = torch
        self.device = "cuda" if torch.cuda.is_available() else "cpu"
        self._network = network.to(self.device).eval()

    def follow(self, pictures: ByteArray, queries: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Follow points through pictures, both ways in time.

        Parameters
        ----------
        pictures : ndarray of uint8, shape (n, side, side, 3)
            In red, green and blue; the network itself takes square ones only.
        queries : ndarray, shape (q, 3)
            Number of a picture, and x and y of a point in it, px; the middle of the first pixel is
            at (0.5, 0.5).

        Returns
        -------
        places : ndarray, shape (q, n, 2)
            x and y in each picture.
        probability : ndarray, shape (q, n)
            That the point is seen there, and is no farther off than the network calls right.
        """
        torch = self._torch
        asked = np.ascontiguousarray(queries[:, [0, 2, 1]], np.float32)
        try:
            with torch.inference_mode(), torch.random.fork_rng(devices=[]):
                torch.manual_seed(0)  # it takes queries in a random order
                video = torch.from_numpy(pictures).to(self.device).float() * (2 / 255) - 1
                found = self._network(video[None], torch.from_numpy(asked).to(self.device)[None])
                hidden, far = (torch.sigmoid(found[k][0]) for k in ("occlusion", "expected_dist"))
                places, sure = found["tracks"][0].cpu(), ((1 - hidden) * (1 - far)).cpu()
        except torch.cuda.OutOfMemoryError:
            n, side = pictures.shape[:2]
            raise InputError(
                f"the memory of the graphics card does not hold {n} pictures of {side} px for the "
                "point tracker; take fewer at once (--set point_tracker.piece_rows=24), smaller "
                f"ones (--set point_tracker.side_px=256), {_MEND}."
            ) from None
        return places.numpy().astype(float), sure.numpy().astype(float)

    def tell_slow(self) -> None:
        """Warn that it will take long where there is no graphics card for it."""
        if self.device == "cpu":
            warn_of_input(
                "torch finds no graphics card, so the point tracker takes several seconds for each "
                "frame and view; with --set point_tracker.side_px=256 a quarter of that, with less "
                "detail.",
                InputWarning,
                stacklevel=2,
            )


def load_tapir(path: Path) -> Tapir:
    """Return the network with the weights of a file; a session reads each file once.

    Parameters
    ----------
    path : Path
        ``bootstapir_checkpoint_v2.pt``.

    Returns
    -------
    Tapir
        The network.

    Raises
    ------
    InputError
        If there is no such file, it has no such weights, or a package is not installed.
    """
    if not path.is_file():
        raise InputError(
            f"[tracking] point_tracker: there is no file {path}; expected the weights of "
            f"BootsTAPIR, from {_WEIGHTS}. Check the path, {_MEND}."
        )
    state = path.stat()
    return _loaded(path, state.st_size, state.st_mtime_ns)


@functools.lru_cache(maxsize=1)
def _loaded(path: Path, size: int, changed: int) -> Tapir:  # noqa: ARG001 (another file then)
    """Return the network with the weights of a file, as long as it stays the same."""
    torch, model = _packages()
    if "causal" in path.name:  # has weights of the same names and shapes
        raise InputError(
            f"[tracking] point_tracker: {path.name} are weights that look back in time only; "
            f"expected those of BootsTAPIR, from {_WEIGHTS}. Name these, {_MEND}."
        )
    network = model.TAPIR(pyramid_level=1)
    try:
        network.load_state_dict(torch.load(path, map_location="cpu", weights_only=True))
    except Exception:  # noqa: BLE001, torch raises many of a file that it cannot read
        raise InputError(
            f"[tracking] point_tracker: {path.name} does not hold the weights of BootsTAPIR; "
            f"expected bootstapir_checkpoint_v2.pt, from {_WEIGHTS}. Download it again, {_MEND}."
        ) from None
    return Tapir(torch, network)


def _packages() -> tuple[Any, Any]:
    """Return torch, and the module of the network."""
    try:
        return importlib.import_module("torch"), importlib.import_module("tapnet.torch.tapir_model")
    except ImportError as error:
        raise InputError(
            "[tracking] point_tracker needs the packages torch and tapnet, and they cannot be "
            f"imported: {error}. Install them with {_INSTALL}, {_MEND}."
        ) from None
