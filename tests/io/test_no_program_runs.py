"""No file that is read can run a program: names in pickles are parsed, never unpickled."""

from __future__ import annotations

import ast
import contextlib
import io
import os
import pickle
import subprocess
import sys
import warnings
from pathlib import Path

import h5py
import numpy as np
import pandas as pd
import pytest
from foreign_files import FPS, WRITERS, write_dlc_h5

import pawnb
from pawnb.cli import main
from pawnb.errors import InputError
from pawnb.io.formats import read_any_tracks
from pawnb.io.pickled_values import read_pickled_values

VALUES = [
    [(1, [("net", "FR", "x"), ("net", "pfote µ", "y")])],
    ["values_block_0", "", "a'b\"c\nd"],
    [1, -5, 2**40, -(2**70), 0.5, -1e300, True, False, None],
    ((), (1,), (1, 2), (1, 2, 3), (1, 2, 3, 4), [], [[]]),
    "text",
]


class Bomb:
    """Unpickled, it makes a file."""

    def __init__(self, marker):
        self.marker = marker

    def __reduce__(self):
        return os.mkdir, (str(self.marker),)


@pytest.mark.parametrize("protocol", range(pickle.HIGHEST_PROTOCOL + 1))
@pytest.mark.parametrize("value", VALUES, ids=str)
def test_plain_values_come_back_as_they_were(protocol, value):
    found = read_pickled_values(pickle.dumps(value, protocol=protocol), where="f")
    assert found == value
    assert type(found) is type(value)


def test_names_written_by_python_2():
    # cPickle of Python 2, protocol 0: str is S'...'
    data = b"(lp1\n(I1\n(lp2\n(S'net'\np3\nS'FR'\np4\nS'x'\np5\ntp6\natp7\na."
    assert read_pickled_values(data, where="f") == [(1, [("net", "FR", "x")])]


@pytest.mark.parametrize("protocol", range(pickle.HIGHEST_PROTOCOL + 1))
@pytest.mark.parametrize("value", [Bomb("x"), {"a": 1}, {1}, np.str_("a"), len, b"bytes", 1j])
def test_everything_else_is_refused(protocol, value):
    if protocol < 3 and isinstance(value, bytes):
        return  # older protocols write bytes as a call, which is a global like the others
    with pytest.raises(InputError, match=r"^f: holds a pickled \w+, which could run a program"):
        read_pickled_values(pickle.dumps([value], protocol=protocol), where="f")


def test_damaged_and_hostile_pickles_are_one_sentence():
    rng = np.random.default_rng(2)
    whole = pickle.dumps(VALUES, protocol=0)
    for seed in range(300):
        data = bytearray(whole)
        if seed % 3 == 0:
            data = data[: rng.integers(len(data))]
        for at in rng.integers(0, max(len(data), 1), 3) if data else ():
            data[at] = rng.integers(256)
        with contextlib.suppress(InputError):
            read_pickled_values(bytes(data), where="f")
    for data in (b"", b".", b"(", b"a.", b"0.", b"g5\n.", b"(" * 10**5,
                 b"L" + b"9" * 10**5 + b"L\n.", b"\x8a\xff" + b"\1" * 255, b"I1e5\n."):  # fmt: skip
        with pytest.raises(InputError, match=r"^f: "):
            read_pickled_values(data + b"a", where="f")


PLACES = ("non_index_axes", "values_cols", "info", "values_block_0_kind", "encoding", "pandas_type")


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("command", ["convert", "gait", "check"])
def test_a_crafted_file_runs_nothing(tmp_path, capsys, monkeypatch, place, command):
    marker = tmp_path / "it_ran"
    bomb = pickle.dumps(Bomb(marker), protocol=0)
    path = write_dlc_h5(tmp_path / "clipDLC.h5", range(60), attributes={place: bomb})
    monkeypatch.chdir(tmp_path)
    (tmp_path / "trial.toml").write_text(
        '[trial]\nkind = "tracks"\nname = "t"\nfps = 100.0\n[tracks]\nfile = "clipDLC.h5"\n'
    )
    words = {"convert": (path.name, "out.nc", "--fps", "100"), "check": (".",),
             "gait": (path.name, "--fps", "100", "--out", "out")}  # fmt: skip
    with pytest.raises(SystemExit) as left:
        sys.exit(main([command, *words[command]]))
    said = capsys.readouterr()
    assert not marker.exists()
    if place not in ("info", "encoding"):  # those two are not read at all
        assert left.value.code == 2
        assert "Traceback" not in said.err
        assert "clipDLC.h5" in said.err
        assert said.err.count("\n") <= 1


def test_the_crafted_file_is_a_real_one(tmp_path):
    # pandas, by which such files were read, does run it
    pytest.importorskip("tables")
    marker = tmp_path / "it_ran"
    bomb = pickle.dumps(Bomb(marker), protocol=0)
    path = write_dlc_h5(tmp_path / "clipDLC.h5", range(3), attributes={"info": bomb})
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        # whatever it makes of it afterwards
        with contextlib.suppress(Exception):
            pd.read_hdf(path, key="df_with_missing")
    assert marker.exists()


@pytest.mark.slow
def test_no_reader_loads_what_could_unpickle(tmp_path):
    paths = [str(write(tmp_path / f"{i}_{name}", range(4)))
             for i, (name, write) in enumerate(WRITERS.values())]  # fmt: skip
    code = (
        "import sys\nfrom pawnb.io.formats import read_any_tracks\n"
        f"for path in {paths!r}: read_any_tracks(path, fps=100.0)\n"
        "print([m for m in ('tables', 'movement', 'sleap_io', 'pynwb') if m in sys.modules])\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.stdout.strip() == "[]", done.stderr


def test_no_module_of_pawnb_unpickles_or_evaluates():
    called = {"eval", "exec", "read_pickle", "read_hdf", "HDFStore", "Unpickler", "loadmat"}
    imported = {"pickle", "dill", "cloudpickle", "joblib", "shelve", "marshal", "tables",
                "movement", "sleap_io"}  # fmt: skip
    for path in Path(pawnb.__file__).parent.rglob("*.py"):
        text = path.read_text(encoding="utf-8")
        if not any(word in text for word in (*called, *imported, "allow_pickle")):
            continue
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.Call):
                bare = isinstance(node.func, ast.Name)
                name = getattr(node.func, "id", getattr(node.func, "attr", None))
                # scipy's reader of MATLAB 5 makes arrays only; classes of MATLAB stay bytes
                own = {"loadmat"} if path.name == "locomouse.py" else set()
                assert name not in (called if bare else called - {"eval", "exec"}) - own, path
                assert all(k.arg != "allow_pickle" for k in node.keywords), path
            if isinstance(node, ast.Import | ast.ImportFrom):
                names = {alias.name.split(".")[0] for alias in node.names}
                names.add((getattr(node, "module", None) or "").split(".")[0])
                assert not names & imported, path


def test_h5_of_deeplabcut_is_read_as_pandas_reads_it(tmp_path):
    pytest.importorskip("tables")
    columns = pd.MultiIndex.from_product(
        [["net"], ["m1", "m2"], ["FR", "HR"], ["x", "y", "likelihood"]],
        names=["scorer", "individuals", "bodyparts", "coords"],
    )
    rng = np.random.default_rng(1)
    table = pd.DataFrame(rng.normal(size=(5, 12)), columns=columns, index=range(3, 8))
    table.iloc[2, 4] = np.nan
    mixed = table.copy()
    mixed[("net", "m2", "HR", "likelihood")] = mixed[("net", "m2", "HR", "likelihood")].astype("f4")
    for frame, layout in ((table, "table"), (table, "fixed"), (mixed, "table"), (mixed, "fixed")):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            frame.to_hdf(tmp_path / "c.h5", key="df_with_missing", format=layout, mode="w")
        tracks = read_any_tracks(tmp_path / "c.h5", fps=FPS)
        assert tracks["frame"].to_numpy().tolist() == [3, 4, 5, 6, 7]
        for who in ("m1", "m2"):
            for point in ("FR", "HR"):
                own = tracks.sel(individual=who, keypoint=point)
                known = frame["net"][who][point].dropna()
                for axis in "xy":
                    np.testing.assert_array_equal(
                        own["position"].sel(space=axis).dropna("time"), known[axis]
                    )


def test_links_out_of_a_file_are_not_followed(tmp_path):
    # a file of somebody else that names another one would be read in its place
    write_dlc_h5(tmp_path / "other.h5", range(5))
    with h5py.File(tmp_path / "clip.h5", "w") as file:
        file["df_with_missing"] = h5py.ExternalLink("other.h5", "df_with_missing")
    with pytest.raises(InputError, match=r"clip.h5: 'df_with_missing' links to elsewhere"):
        read_any_tracks(tmp_path / "clip.h5", fps=FPS)
    (tmp_path / "raw").write_bytes(bytes(8 * 40))
    with h5py.File(tmp_path / "clip.nc", "w") as file:
        file.create_dataset("position", (10, 4), "f8", external=[("raw", 0, 320)])
    with pytest.raises(InputError, match=r"clip.nc: 'position' lies in another file"):
        read_any_tracks(tmp_path / "clip.nc", fps=FPS)


def test_data_larger_than_its_file_are_refused(tmp_path):
    with h5py.File(tmp_path / "clip.h5", "w") as file:
        file.create_dataset("tracks", (1, 2, 4, 2**40), "f8", chunks=(1, 2, 4, 64))
        file["node_names"] = np.array([b"a"] * 4)
    with pytest.raises(InputError, match=r"'tracks' claims 70368.7 GB of which the file holds 0"):
        read_any_tracks(tmp_path / "clip.h5", fps=FPS)


def test_a_bomb_is_no_bomb_for_the_reader_alone(tmp_path):
    data = io.BytesIO()
    pickle.Pickler(data, protocol=4).dump([Bomb(tmp_path / "ran")])
    with pytest.raises(InputError, match="could run a program"):
        read_pickled_values(data.getvalue(), where="f")
    assert not (tmp_path / "ran").exists()
