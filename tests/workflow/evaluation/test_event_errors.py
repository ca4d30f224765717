"""Times of events: matched by hand."""

import numpy as np
import pandas as pd
import pytest

from pawnb.errors import InputError
from pawnb.workflow.evaluation.event_errors import measure_event_errors


def events(leg, kind, frames):
    return pd.DataFrame({"leg": leg, "event": kind, "frame": frames})


def test_event_times_are_matched_nearest_first():
    truth = pd.concat([events("L1", "AEP", [2.0, 10.0, 20.0, 30.0, 41.0]),
                       events("L1", "PEP", [15.0])])  # fmt: skip
    found = pd.concat([events("L1", "AEP", [10.3, 19.5, 22.0, 40.0]),
                       events("L1", "PEP", [15.2])])  # fmt: skip
    table = measure_event_errors(found, truth)
    aep = table[table["event"] == "AEP"]
    # 2.0 is before tracking began; 30 was missed; 22.0 is one too many
    assert aep["frame_true"].tolist() == pytest.approx([10, 20, np.nan, 30, 41], nan_ok=True)
    assert aep["difference"].tolist() == pytest.approx(
        [0.3, -0.5, np.nan, np.nan, -1.0], nan_ok=True
    )
    assert table[table["event"] == "PEP"]["difference"].tolist() == pytest.approx([0.2])


def test_no_events_are_said():
    with pytest.raises(InputError, match="no events were found"):
        measure_event_errors(events("L1", "AEP", []), events("L1", "AEP", [3.0]))
