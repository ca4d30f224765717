"""The engine: frames, calibration, filters and trackers; it knows no gait and no widget."""
