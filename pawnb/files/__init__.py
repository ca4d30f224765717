"""How everything gets to disk: whole files, locks, and names that stay in their folder.

Every writer of pawnb goes through :func:`write_whole` or :func:`whole_file`: a file is written
beside its place, forced to disk and renamed, so that a reader never meets half of it.
"""

from pawnb.files.lock import locked
from pawnb.files.names import child_folder, distinct_name, safe_name
from pawnb.files.whole import is_leftover, remove_leftovers, sync_folder, whole_file, write_whole

__all__ = [
    "child_folder",
    "distinct_name",
    "is_leftover",
    "locked",
    "remove_leftovers",
    "safe_name",
    "sync_folder",
    "whole_file",
    "write_whole",
]
