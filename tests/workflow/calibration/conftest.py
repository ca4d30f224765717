"""The scene of a board is shared with the tests of the engine."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[2] / "core" / "calibration"))
