"""Everything between pawnb and the disk: reading, whole files, locks, names.

What a person names is read by :func:`read_text`, :func:`read_bytes` or :func:`read_toml`, which
refuse pipes, devices, folders and what is too large. Everything is written by :func:`write_whole`
or :func:`whole_file`: beside its place, forced to disk and renamed, so that a reader never meets
half of it. What grows record by record is added to by :func:`write_at`; files that belong together
are :func:`staged` and replaced by their :class:`Listing`. What several windows may have open at
once goes through a :class:`GuardedFile`. Nothing else in pawnb writes to the disk.
"""

from pawnb.files.folder import Listing, check_replaceable, staged, staged_files
from pawnb.files.growing import open_growing, write_at
from pawnb.files.guard import GuardedFile, find_standing_folder, say_moved
from pawnb.files.lock import locked
from pawnb.files.names import as_word, child_folder, distinct_name, safe_name
from pawnb.files.reading import (
    MOST_TABLE_BYTES,
    MOST_TEXT_BYTES,
    check_file,
    parse_toml,
    read_bytes,
    read_text,
    read_toml,
)
from pawnb.files.refused import how_to_write
from pawnb.files.whole import (
    is_copy,
    is_leftover,
    keep_copy,
    remove_leftovers,
    sync_folder,
    whole_file,
    write_new,
    write_whole,
)

__all__ = [
    "MOST_TABLE_BYTES",
    "MOST_TEXT_BYTES",
    "GuardedFile",
    "Listing",
    "as_word",
    "check_file",
    "check_replaceable",
    "child_folder",
    "distinct_name",
    "find_standing_folder",
    "how_to_write",
    "is_copy",
    "is_leftover",
    "keep_copy",
    "locked",
    "open_growing",
    "parse_toml",
    "read_bytes",
    "read_text",
    "read_toml",
    "remove_leftovers",
    "safe_name",
    "say_moved",
    "staged",
    "staged_files",
    "sync_folder",
    "whole_file",
    "write_at",
    "write_new",
    "write_whole",
]


def __dir__() -> list[str]:
    """List the public names."""
    return sorted(__all__)
