"""What is installed elsewhere: the wheel, the conda recipe, and that they name the same needs."""

import re
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest

import pawnb

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
# conda-forge gives these packages other names, and opencv's releases three numbers, not four
CONDA = {"matplotlib": "matplotlib-base", "opencv-python-headless": "py-opencv"}


def conda_requirements(dependencies):
    out = set()
    for item in dependencies:
        name, least = item.split(">=")
        out.add(f"{CONDA.get(name, name)} >={'.'.join(least.split('.')[:3])}")
    return out


@pytest.mark.parametrize("path", ["packaging/conda/recipe.yaml", "environment.yml"])
def test_conda_asks_for_what_pip_asks_for(path):
    text = (ROOT / path).read_text(encoding="utf-8")
    named = set(re.findall(r"^ +- ([\w-]+ >=[\d.]+)$", text, re.M))
    assert named - {"hatchling >=1.25"} == conda_requirements(PROJECT["dependencies"])
    assert f"python {PROJECT['requires-python']}" in text


def test_the_recipe_has_the_version_and_the_command_of_the_package():
    text = (ROOT / "packaging/conda/recipe.yaml").read_text(encoding="utf-8")
    assert f'version: "{pawnb.__version__}"' in text
    for name, place in PROJECT["scripts"].items():
        assert f"- {name} = {place}" in text


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    folder = tmp_path_factory.mktemp("built")
    wheel = [sys.executable, "-m", "pip", "wheel", "-q", "--no-deps", "-w", str(folder), str(ROOT)]
    subprocess.run(wheel, check=True)
    return next(folder.glob("*.whl"))


@pytest.mark.slow
def test_the_wheel_holds_what_is_not_python(built):
    names = set(zipfile.ZipFile(built).namelist())
    for path in (ROOT / "pawnb").rglob("*"):
        inside = path.relative_to(ROOT).as_posix()
        if path.is_file() and "__pycache__" not in inside and not path.name.endswith(".nbi"):
            assert inside in names
    for path in (ROOT / "notebooks").glob("*.ipynb"):
        assert f"pawnb/notebooks/{path.name}" in names


@pytest.mark.slow
def test_the_wheel_works_outside_the_checkout(built, tmp_path):
    place = tmp_path / "installed"
    install = [sys.executable, "-m", "pip", "install", "-q", "--no-deps", "--target", str(place)]
    subprocess.run([*install, str(built)], check=True)
    run = (
        "import sys; sys.path.insert(0, sys.argv.pop(1)); import pawnb; "
        "assert pawnb.__file__.startswith(sys.path[0]), pawnb.__file__; "
        "from pawnb.cli import main; sys.exit(main(sys.argv[1:]))"
    )
    for words in (
        ["demo", "paws", "--out", "demo", "--frames", "60", "--scale", "0.2"],
        ["check", "demo"],
        ["gait", "demo/truth/events.csv", "--out", "gait"],
    ):
        command = [sys.executable, "-c", run, str(place), *words]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
    assert (tmp_path / "gait" / "strides.csv").exists()
