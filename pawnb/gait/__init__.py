"""Gait statistics on tracks or events from any source; this part knows no video."""
