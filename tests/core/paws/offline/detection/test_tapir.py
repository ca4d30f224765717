"""The network that follows points: its packages, its weights, and its pixels."""

from __future__ import annotations

import sys
from types import ModuleType, SimpleNamespace

import cv2
import numpy as np
import pytest

from pawnb.core.paws.offline.detection.point_tracking.tapir import Tapir, load_tapir
from pawnb.errors import InputError, InputWarning


def test_a_file_that_is_not_there_is_named_with_where_to_get_it(tmp_path):
    with pytest.raises(InputError, match=r"no file .*net\.pt; expected .*bootstapir_checkpoint_v2"):
        load_tapir(tmp_path / "net.pt")


@pytest.mark.parametrize("missing", ["torch", "tapnet"])
def test_a_package_that_is_not_there_is_named_with_how_to_get_it(tmp_path, monkeypatch, missing):
    file = tmp_path / "net.pt"
    file.write_bytes(b"weights")
    monkeypatch.setitem(sys.modules, "torch", ModuleType("torch"))
    monkeypatch.setitem(sys.modules, missing, None)  # what import takes for not there
    with pytest.raises(InputError, match=rf"cannot be imported: .*{missing}.* pip install"):
        load_tapir(file)


class Module:
    """As much of a network of torch as is asked of it."""

    def __init__(self, *, pyramid_level):
        self.pyramid_level = pyramid_level

    def load_state_dict(self, state):
        if "resnet" not in state:
            raise RuntimeError("Missing key(s) in state_dict")

    def to(self, _device):
        return self

    def eval(self):
        return self


def offer(monkeypatch, load, *, card=False):
    """Put modules in place of torch and tapnet; what was loaded before is forgotten."""
    torch, tapnet, inner, model = map(
        ModuleType, ("torch", "tapnet", "tapnet.torch", "tapnet.torch.tapir_model")
    )
    torch.load = load
    torch.cuda = SimpleNamespace(is_available=lambda: card)
    model.TAPIR = Module
    for module in (torch, tapnet, inner, model):
        monkeypatch.setitem(sys.modules, module.__name__, module)


def file_of(tmp_path, name="bootstapir_checkpoint_v2.pt"):
    file = tmp_path / name
    file.write_bytes(b"weights")
    return file


def test_weights_are_read_once_and_run_no_code_of_the_file(tmp_path, monkeypatch):
    asked = []

    def load(path, *, map_location, weights_only):
        asked.append((path.name, map_location, weights_only))
        return {"resnet": 1}

    offer(monkeypatch, load)
    file = file_of(tmp_path)
    assert load_tapir(file) is load_tapir(file)
    assert asked == [("bootstapir_checkpoint_v2.pt", "cpu", True)]
    file.write_bytes(b"others of another size")
    load_tapir(file)
    assert len(asked) == 2


def broken(*_, **__):
    raise EOFError("Ran out of input")


@pytest.mark.parametrize("load", [broken, lambda *_, **__: {"head": 1}], ids=["cut", "others"])
def test_what_is_not_these_weights_is_refused(tmp_path, monkeypatch, load):
    offer(monkeypatch, load)
    with pytest.raises(InputError, match="does not hold the weights of BootsTAPIR; expected"):
        load_tapir(file_of(tmp_path))


def test_weights_that_cannot_be_told_by_their_content_are_told_by_their_name(tmp_path, monkeypatch):
    offer(monkeypatch, lambda *_, **__: {"resnet": 1})
    with pytest.raises(InputError, match="look back in time only"):
        load_tapir(file_of(tmp_path, "causal_bootstapir_checkpoint.pt"))


def test_it_is_said_that_it_is_slow_without_a_graphics_card(tmp_path, monkeypatch, recwarn):
    offer(monkeypatch, lambda *_, **__: {"resnet": 1}, card=True)
    load_tapir(file_of(tmp_path, "a.pt")).tell_slow()
    assert not recwarn
    offer(monkeypatch, lambda *_, **__: {"resnet": 1})
    with pytest.warns(InputWarning, match="no graphics card.*several seconds"):
        load_tapir(file_of(tmp_path, "b.pt")).tell_slow()


def matcher(model):
    """Return the real network with a head that takes the best match of untrained features.

    Convolutions with random weights tell places apart; nothing is refined, so that where the best
    match is must come out, in the pixels in which the query went in.
    """
    import torch

    torch.manual_seed(1)
    network = model.TAPIR(pyramid_level=1)
    with torch.no_grad():
        head = network.torch_cost_volume_track_mods
        for name in ("hid1", "hid2"):
            head[name].weight.zero_()
            head[name].bias.zero_()
        head["hid1"].weight[0, 0, 1, 1] = 1.0
        head["hid2"].weight[0, 0, 1, 1] = 20.0
        head["occ_out"].weight.zero_()
        head["occ_out"].bias[:] = torch.tensor([-3.0, -2.0])
        network.torch_pips_mixer.linear_1.weight.zero_()
        network.torch_pips_mixer.linear_1.bias.zero_()
    return network


def test_the_real_network_speaks_of_the_pixels_that_it_is_asked_in(tmp_path):
    """Only its weights are not the trained ones, which nobody here has."""
    why = "needs torch and tapnet, which pawnb does not"
    torch = pytest.importorskip("torch", reason=why)
    model = pytest.importorskip("tapnet.torch.tapir_model", reason=why)
    file = tmp_path / "random.pt"
    torch.save(matcher(model).state_dict(), file)
    network = load_tapir(file)
    assert isinstance(network, Tapir)
    random = np.random.default_rng(0)
    noise = cv2.GaussianBlur(random.normal(size=(400, 400, 3)), (0, 0), 3)
    noise = np.uint8(np.clip(128 + 50 * noise / noise.std(), 0, 255))
    shift = np.array([[0, 0], [16, 8], [32, -16], [-24, 24]])
    film = np.stack([noise[64 - v : 320 - v, 64 - u : 320 - u] for u, v in shift])
    queries = np.array([[0, 100.5, 140.5], [2, 150.5, 90.5]])
    places, probability = network.follow(film, queries)
    assert places.shape == (2, 4, 2)
    expected = queries[:, None, 1:] + shift[None] - shift[[0, 2]][:, None]
    # a place of the features is 8 px
    assert np.abs(places - expected).max() < 4
    # (1 - sigmoid(-3)) (1 - sigmoid(-2)), worked out by hand
    np.testing.assert_allclose(probability[0, 1:], 0.9526 * 0.8808, atol=1e-3)
    again, _ = network.follow(film, queries)
    np.testing.assert_array_equal(places, again)
