"""Phases between legs, and what they say of coordination.

Comes in: events and strides. Goes out: the phase of each leg in the stride of another, and measures
of coordination. The table of phases and its summary are here itself (from ``phase_table``).
``coupling`` has rules and models of how legs are coupled, ``patterns`` distances to ideal gaits,
``relative_phase`` the phase at every instant, ``density`` its density on the torus.
"""

from pawnb import _lazy
from pawnb.gait.phases.phase_table import (
    build_phases,
    describe_phases,
    phase_lags,
    summarise_phases,
)

__all__ = [
    "build_phases",
    "coupling",
    "density",
    "describe_phases",
    "patterns",
    "phase_lags",
    "relative_phase",
    "summarise_phases",
]

__getattr__, __dir__ = _lazy(__name__, __all__)
