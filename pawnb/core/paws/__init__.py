"""The 2019 system: points tracked by superpixels in one or more views."""
