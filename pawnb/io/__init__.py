"""Tracks in and out: our own files and other programs', one file each."""

from pawnb import _submodules

__getattr__ = _submodules(__name__)
