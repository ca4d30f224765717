"""What the statistics share; the tests and models themselves are public modules of gait.

Comes in: checked samples. Goes out: fits, permutations and shares of variance for those modules.
``checks`` of input; ``linear_fit``; ``permutations``, ``leg_permutation``; ``fixed_effects`` and
``mixed_likelihood`` of mixed models; ``variance_shares``; ``animal_phases``, ``circular_length``,
``circular_sample`` of phases.
"""

from pawnb import _lazy

__all__ = [
    "animal_phases",
    "checks",
    "circular_length",
    "circular_sample",
    "fixed_effects",
    "leg_permutation",
    "linear_fit",
    "mixed_likelihood",
    "permutations",
    "variance_shares",
]

__getattr__, __dir__ = _lazy(__name__, __all__)
