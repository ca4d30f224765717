"""Figures from tables, one a file."""
