"""Species files that come with the package; see :mod:`pawnb.core.pose.species_file`."""
