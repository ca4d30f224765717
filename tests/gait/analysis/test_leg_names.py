"""Names of feet as users of other programs give them (each list is one from a public project)."""

import pytest

from pawnb.gait.analysis.leg_names import guess_legs


@pytest.mark.parametrize(
    ("points", "legs"),
    [
        # B-SOiD open field (DeepLabCut)
        (
            ["Snout", "Front Paw R", "Front Paw L", "Hind Paw R", "Hind Paw L", "Butt"],
            {"FR": "Front Paw R", "FL": "Front Paw L", "HR": "Hind Paw R", "HL": "Hind Paw L"},
        ),
        # SLEAP's fly skeleton: wings and eyes are no legs
        (
            ["head", "wingL", "wingR", "forelegL4", "midlegR4", "hindlegL4", "eyeL"],
            {"LF": "forelegL4", "RM": "midlegR4", "LH": "hindlegL4"},
        ),
        # Anipose's fly: A is the coxa, E the tip
        (["L1A", "L1B", "L1E", "R3D", "R3E"], {"L1": "L1E", "R3": "R3E"}),
        # several points of a leg: the outermost
        (["LF_Femur", "LF_Claw", "LF_Tarsus", "RM_Claw"], {"LF": "LF_Claw", "RM": "RM_Claw"}),
        (["hindpaw_left", "leftFrontPaw", "RH toe", "RH ankle"],
         {"HL": "hindpaw_left", "FL": "leftFrontPaw", "HR": "RH toe"}),
        (["paw_FL", "paw_HR", "nose"], {"FL": "paw_FL", "HR": "paw_HR"}),
        (["FR", "HR", "nose", "left paw"], {"FR": "FR", "HR": "HR"}),
        # one leg by pawnb's name, the others in words
        (["front left paw", "hind_left (paw)", "HR", "HR paw"],
         {"HR": "HR", "FL": "front left paw", "HL": "hind_left (paw)"}),
        (["L1", "R1", "front left paw"], {"L1": "L1", "R1": "R1"}),
        # no side, or no leg: nothing is guessed
        (["Nose", "Ear base", "Hind paw tao"], {}),
        (["left_ear", "right_ear", "back", "tail_front"], {}),
    ],
)  # fmt: skip
def test_feet_are_found_by_their_names(points, legs):
    assert guess_legs(points) == legs
