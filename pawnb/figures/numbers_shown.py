"""How numbers are written in figures."""

from __future__ import annotations


def say_number(value: float) -> str:
    """Write three digits, as short as they can be: 5030 and not 5.03e+03.

    Parameters
    ----------
    value : float
        The number.

    Returns
    -------
    str
        With a true minus sign.
    """
    words = f"{value:.3g}" if abs(value) < 1000.0 or abs(value) >= 1e6 else f"{value:.0f}"
    return words.replace("e-0", "e-").replace("-", "−")
