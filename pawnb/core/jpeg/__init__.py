"""Baseline JPEG pictures, of which any part can be decoded by itself."""
