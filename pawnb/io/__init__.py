"""Tracks in and out: our own files and other programs', one file each."""
