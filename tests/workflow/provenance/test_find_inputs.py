"""Inputs of a run are found as they were then."""

import pytest

from pawnb.errors import InputError
from pawnb.workflow.provenance.find_inputs import find_inputs
from pawnb.workflow.provenance.record import file_checksum


def test_a_folder_with_a_file_for_each_foot_is_an_input(tmp_path):
    """As a trial of Tracker's tables is; it was said not to be there."""
    feet = tmp_path / "m1" / "feet"
    feet.mkdir(parents=True)
    for foot in ("FR", "HR"):
        (feet / f"{foot}.csv").write_text(f",{foot},,\nt,x,y,\n0,1,2\n")
    known = {"m1/feet": file_checksum(feet)}
    (tmp_path / "later" / "feet").mkdir(parents=True)  # an empty one of that name is none
    for places in ([tmp_path], [feet.parent], [tmp_path / "later", tmp_path]):
        assert find_inputs(known, places, of="strides.csv") == {"m1/feet": feet}
    (feet / "HR.csv").write_text("\n")
    with pytest.raises(InputError, match=r"feet has changed since strides.csv was made of it"):
        find_inputs(known, [tmp_path], of="strides.csv")
