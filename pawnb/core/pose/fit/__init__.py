"""The pose tracker of pawnb: a painted stick animal fitted to the picture."""
