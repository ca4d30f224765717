"""Notebooks on a recording of one's own, for which only what they say is changed."""

import re
import shutil

import pandas as pd
import pytest
from notebook_runs import FOLDER, NOTEBOOKS, execute, printed, shown

import pawnb
from pawnb.synthetic import write_deeplabcut_sample

# 01 is about one real clip, 06 about the synthetic spiders of the thesis
OF_OWN_DATA = [path for path in NOTEBOOKS if path.name[:2] not in ("01", "06")]


@pytest.mark.parametrize("path", OF_OWN_DATA, ids=lambda path: path.name)
def test_below_the_first_cell_nothing_is_that_of_the_sample(path):
    import nbformat  # takes seconds to import

    cells = nbformat.read(path, as_version=4).cells
    _, *below = [cell.source for cell in cells if cell.cell_type == "code"]
    for source in below:
        assert "sample/" not in source
        assert not re.search(r'unit="|\(mm', source)


@pytest.mark.slow
def test_quick_start_keeps_a_recording_of_ones_own_in_its_folder(tmp_path):
    pawnb.sample_trial(tmp_path / "my-folder", frames=150, scale=0.2)
    shutil.rmtree(tmp_path / "my-folder" / "truth")  # of one's own nobody knows it
    own = {'pawnb.sample_trial("sample/paws")': 'pawnb.load_trial("my-folder")'}
    notebook = execute(FOLDER / "00_quickstart.ipynb", tmp_path, own)
    assert (tmp_path / "my-folder" / "results" / "tracks.nc").exists()
    assert not (tmp_path / "sample").exists()
    assert shown(notebook, "image/png") == 2
    assert "no truth is known" in printed(notebook)


@pytest.mark.slow
def test_spider_notebook_keeps_a_recording_of_ones_own_in_its_folder(tmp_path):
    pawnb.sample_trial(tmp_path / "my-folder", scene="spider", frames=120, scale=0.3)
    shutil.rmtree(tmp_path / "my-folder" / "truth")
    toml = tmp_path / "my-folder" / "trial.toml"
    text = toml.read_text(encoding="utf-8")
    toml.write_text(text.replace('name = "top"', 'name = "from above"'), encoding="utf-8")
    own = {'pawnb.sample_trial("sample/spider", scene="spider")': 'pawnb.load_trial("my-folder")'}
    notebook = execute(
        FOLDER / "02_spider_pose.ipynb", tmp_path, own, PAWNB_TEST_DATA=str(tmp_path)
    )
    assert (tmp_path / "my-folder" / "results" / "tracks.nc").exists()
    assert not (tmp_path / "sample").exists()
    assert "no truth is known" in printed(notebook)


@pytest.fixture
def own_files(tmp_path):
    """Write three mice as DeepLabCut does, filmed at 200 frames a second; return their truth."""
    write_deeplabcut_sample(tmp_path / "my-tracks", animals=3)
    truth = tmp_path / "my-tracks" / "truth.csv"
    table = pd.read_csv(truth)
    truth.unlink()
    return table


@pytest.mark.slow
def test_foreign_tracks_take_the_frame_rate_and_groups_that_are_said(tmp_path, own_files):
    write_deeplabcut_sample(tmp_path / "sample" / "deeplabcut", animals=6)  # as it was run before
    own = {
        'write_deeplabcut_sample("sample/deeplabcut", animals=6)':
            'sorted(Path("my-tracks").glob("*.csv"))',
        "fps = 200.0": "fps = 100.0",
        'pd.read_csv("sample/deeplabcut/truth.csv")': "None",
        'dict(zip(truth["animal"], truth["group"]))': '{"m01": "a", "m02": "b", "m04": "b"}',
    }  # fmt: skip
    notebook = execute(FOLDER / "04_from_deeplabcut.ipynb", tmp_path, own)
    strides = pd.read_csv(tmp_path / "results" / "deeplabcut" / "strides.csv")
    found = strides.groupby("animal")["period_s"].mean()
    # half the frames a second: each stride takes twice as long as in the sample's truth
    assert found.to_numpy() == pytest.approx(2 * own_files["period_s"].to_numpy(), rel=0.02)
    text = printed(notebook)
    assert "in no group: ['m03']" in text
    assert "largest error of the period" not in text


@pytest.mark.slow
def test_cut_off_notebook_takes_the_unit_and_frame_rate_of_the_file(tmp_path, real_data):
    file = real_data("mouse-openfield-dlc") / "raw_clip1DLC.csv"
    lines = file.read_text(encoding="utf-8").splitlines(keepends=True)
    (tmp_path / "clip.csv").write_text("".join(lines[:1203]), encoding="utf-8")  # 3 of header
    own = {
        'write_deeplabcut_sample("sample/deeplabcut", animals=6)[0]': '"clip.csv"',
        "fs_hz = 200.0": "fs_hz = 60.0",
    }
    text = printed(execute(FOLDER / "05_residual_analysis.ipynb", tmp_path, own))
    assert "Front Paw R" in text
    cutoff_hz = float(re.search(r"residual: ([0-9.]+) Hz", text)[1])
    assert 0.0 < cutoff_hz < 30.0  # below half of the frame rate


@pytest.mark.slow
def test_statistics_of_own_trials_are_in_their_unit_and_have_no_truth(tmp_path, own_files):
    for animal in own_files["animal"]:
        folder = tmp_path / animal
        folder.mkdir()
        shutil.copy(tmp_path / "my-tracks" / f"{animal}DLC.csv", folder)
        trial = pawnb.Trial(
            kind="tracks", name=f"{animal}-1", fps=200.0, folder=folder,
            animal=pawnb.Animal(id=animal), tracks_file=f"{animal}DLC.csv",
        )  # fmt: skip
        pawnb.save_trial(trial, folder / "trial.toml")
    path = FOLDER / "03_gait_statistics.ipynb"
    notebook = execute(path, tmp_path, of_ones_own(path, '["m01", "m02", "m03"]'))
    text = printed(notebook)
    assert "lengths in px" in text
    assert "from the truth" not in text
    assert "legs were guessed" in text  # what pawnb gait would say
    assert shown(notebook, "image/png") == 3


def of_ones_own(path, folders):
    """Put the lines below ``your own`` of a notebook in the place of those above it."""
    import nbformat  # takes seconds to import

    first = next(c for c in nbformat.read(path, as_version=4).cells if c.cell_type == "code")
    above, below = re.split("# your own: .*\n", first.source)
    sample = above[above.index("study = ") :]
    lines = [line.removeprefix("# ") for line in below.splitlines() if line.startswith("# ")]
    assert lines[0].count('["m07-1", "m07-2", "m08-1"]') == 1
    lines[0] = lines[0].replace('["m07-1", "m07-2", "m08-1"]', folders)
    return {sample: "\n".join(lines) + "\n"}
