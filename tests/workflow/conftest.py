"""What several tests of the workflow start from."""

from __future__ import annotations

import shutil

import pytest


@pytest.fixture
def trials(rendered_spider, tmp_path):
    """Return two trials of a spider and one whose video is missing, side by side."""
    folder = tmp_path / "trials"
    for name in ("a", "b", "broken"):
        shutil.copytree(rendered_spider, folder / name)
        toml = folder / name / "trial.toml"
        toml.write_text(toml.read_text().replace('name = "spider-', f'name = "{name}-'))
    (folder / "broken" / "spider.avi").unlink()
    return folder
