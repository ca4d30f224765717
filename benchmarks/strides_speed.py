"""How long the analysis of many strides takes, from events to every table.

    python benchmarks/strides_speed.py [--strides 100000]

Events of 25 eight-legged animals with independent jitter are made, then analysed: strides,
phases of 16 pairs, their summary over animals, and the tables of coordination.
"""

from __future__ import annotations

import argparse
import time

import numpy as np
import pandas as pd

from pawnb.gait import analyse_events
from pawnb.gait.coordination import coordination_tables

LEGS = ("L1", "L2", "L3", "L4", "R1", "R2", "R3", "R4")
ANIMALS = 25


def make_events(strides: int, *, seed: int = 0) -> pd.DataFrame:
    """Return AEP and PEP of as many strides, spread over animals and legs."""
    rng = np.random.default_rng(seed)
    each = max(2, round(strides / (ANIMALS * len(LEGS)))) + 1
    parts = []
    for animal in range(ANIMALS):
        start = np.cumsum(0.2 + 0.01 * rng.standard_normal(each))
        for number, leg in enumerate(LEGS):
            lag = 0.1 * ((number + number // 4) % 2)
            down = start + lag + 0.005 * rng.standard_normal(each)
            for event, at in (("AEP", down), ("PEP", down + 0.12)):
                who = {"animal": f"a{animal:02d}", "trial": f"t{animal:02d}", "leg": leg}
                columns = {**who, "event": event, "frame": at * 125.0, "time_s": at}
                parts.append(pd.DataFrame({**columns, "method": "made"}))
    return pd.concat(parts, ignore_index=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--strides", type=int, default=100_000)
    options = parser.parse_args()
    events = make_events(options.strides)
    begun = time.perf_counter()
    tables = analyse_events(events)
    analysed = time.perf_counter()
    coordination_tables(tables)
    done = time.perf_counter()
    print(f"{len(tables.strides)} strides and {len(tables.phases)} phases")
    print(f"strides, phases and their summary: {analysed - begun:.1f} s")
    print(f"tables of coordination: {done - analysed:.1f} s")


if __name__ == "__main__":
    main()
