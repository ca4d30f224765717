"""Figures are drawn from the walking animals of the tests of gait."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[1] / "gait"))
