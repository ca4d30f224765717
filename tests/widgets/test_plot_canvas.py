"""Figures of widgets leave the figures of pyplot alone."""

import subprocess
import sys

import pytest

SOURCE = """
import warnings
warnings.simplefilter("ignore")
import matplotlib, numpy as np, pandas as pd
matplotlib.use("svg")
import matplotlib.pyplot as plt
from pawnb.widgets import ResidualExplorer, GaitExplorer
signal = np.sin(np.arange(200) / 9.0) + 0.01 * np.cos(np.arange(200) * 2.5)
explorer = ResidualExplorer(pd.DataFrame({"a": signal}), fs_hz=100.0)
print(type(explorer._canvas).__module__, matplotlib.get_backend(),
      type(plt.figure().canvas).__name__)
"""


@pytest.mark.slow
def test_the_backend_stays():
    # a process of its own: ipympl takes pyplot over when it is first imported
    done = subprocess.run([sys.executable, "-c", SOURCE], capture_output=True, text=True)
    assert done.stdout.split() == ["ipympl.backend_nbagg", "svg", "FigureCanvasSVG"], done.stderr
