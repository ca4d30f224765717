"""Libraries of extras: what is not installed is said, whatever lies beside a notebook."""

import pytest

from pawnb.errors import InputError
from pawnb.io.extras import need


def test_a_folder_of_the_name_of_a_library_is_not_the_library(tmp_path, monkeypatch):
    # data in a folder c3d beside the notebook: Python imports it as a package without anything
    (tmp_path / "no_such_library").mkdir()
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(InputError, match=r"is not installed; .*pawnb\[c3d\]"):
        need("no_such_library", "c3d", what="to read clip.c3d")
