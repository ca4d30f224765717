"""Trial to tracks to gait, each step one call."""
