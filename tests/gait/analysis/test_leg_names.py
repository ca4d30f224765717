"""Names of feet as users of other programs give them (each list is one from a public project)."""

import numpy as np
import pytest

from pawnb.errors import InputError
from pawnb.gait.analysis.leg_names import (
    choose_legs,
    guess_legs,
    notes_on_legs,
    overlooked_points,
    rival_points,
)
from pawnb.schema import make_tracks
from pawnb.trial import Animal, Trial


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
        # rear and back legs by their letters, beside those of the front ones (CatWalk, DigiGait)
        (["FL", "FR", "RL", "RR"], {"FL": "FL", "FR": "FR", "HL": "RL", "HR": "RR"}),
        (["LF", "RF", "LR", "RR"], {"LF": "LF", "RF": "RF", "LH": "LR", "RH": "RR"}),
        (["paw_fl", "paw_fr", "paw_bl"], {"FL": "paw_fl", "FR": "paw_fr", "HL": "paw_bl"}),
        (["FL", "HL", "RR"], {"FL": "FL", "HL": "HL"}),
        # "fr" is short for front where the side is said besides
        (["l_fr_paw", "r_fr_paw", "l_hd_paw"],
         {"FL": "l_fr_paw", "FR": "r_fr_paw", "HL": "l_hd_paw"}),
        (["r_fl_paw"], {}),
        # legs that are counted; an ear's tip and the toes of a paw are counted, too
        (["claw_L1", "tibia_tarsus_L1", "R4_tip", "leg2L"],
         {"L1": "claw_L1", "R4": "R4_tip", "L2": "leg2L"}),
        (["ear_tip_L1", "left_toe1"], {}),
        (["rfpaw", "lhpaw"], {"FR": "rfpaw", "HL": "lhpaw"}),
        # nothing but side and place: all four, else it may be a part of the back
        (["left_front", "left_back", "right_front", "RightBack"],
         {"FL": "left_front", "HL": "left_back", "FR": "right_front", "HR": "RightBack"}),
        (["left_back", "right_back"], {}),
        # no side, or no leg: nothing is guessed
        (["Nose", "Ear base", "Hind paw tao"], {}),
        (["left_ear", "right_ear", "back", "tail_front"], {}),
        # Chinese, simplified and not, and Japanese; 中 is the middle leg of an insect
        (["左前爪", "右前爪", "左后爪", "右后爪", "左耳", "尾"],
         {"FL": "左前爪", "FR": "右前爪", "HL": "左后爪", "HR": "右后爪"}),
        (["左前足", "左中足", "左後足", "右前足", "右中足", "右後足"],
         {"LF": "左前足", "LM": "左中足", "LH": "左後足",
          "RF": "右前足", "RM": "右中足", "RH": "右後足"}),
        # arachnologists count legs by Roman numbers
        (["LegI_L", "LegII_L", "LegIII_L", "LegIV_L", "LegIV_R"],
         {"L1": "LegI_L", "L2": "LegII_L", "L3": "LegIII_L", "L4": "LegIV_L", "R4": "LegIV_R"}),
        (["LI", "LII", "LIII", "LIV", "RI"],
         {"L1": "LI", "L2": "LII", "L3": "LIII", "L4": "LIV", "R1": "RI"}),
        (["iv leg left", "RI"], {}),  # by themselves these are no numbers
    ],
)  # fmt: skip
def test_feet_are_found_by_their_names(points, legs):
    assert guess_legs(points) == legs


@pytest.mark.parametrize(
    ("points", "left_out"),
    [
        (["FR", "FL", "left paw", "snout", "tail tip"], ["left paw"]),
        (["FR_paw", "FL_paw", "hind1_paw", "FR_wrist"], ["hind1_paw"]),
        # all points of legs that are there
        (["LF_Claw", "LF_Tarsus", "RM_Claw", "eye_L"], []),
        # two sides in one name: FL is left in itself
        (["FR_paw", "R_FL"], ["R_FL"]),
        # a leg of another kind than the others
        (["L1", "R1", "front left paw"], []),
    ],
)
def test_points_that_may_be_feet_and_are_left_out_are_found(points, left_out):
    assert overlooked_points(points, guess_legs(points)) == left_out


def test_the_message_takes_a_point_of_a_limb_for_its_example():
    tracks = make_tracks([0, 1], ["snout", "Hind paw tao", "Tail tip"], fps=100.0, unit="px")
    with pytest.raises(InputError, match="--legs HR='Hind paw tao'"):
        choose_legs(tracks)


def test_legs_that_are_chosen_by_their_names_are_the_points_of_these_legs():
    points = ["forepaw_R", "hindpaw_R", "hindpaw_L", "tip"]
    tracks = make_tracks([0, 1], points, fps=100.0, unit="px")
    assert choose_legs(tracks, legs=["HR", "HL"]) == {"HR": "hindpaw_R", "HL": "hindpaw_L"}
    assert choose_legs(tracks, legs=["tip"]) == {"tip": "tip"}


def in_order(*points):
    """The four legs by the names of the front left, front right, hind left and hind right."""
    return dict(zip(("FL", "FR", "HL", "HR"), points, strict=True))


@pytest.mark.parametrize(
    "names",
    [
        ("Vorderpfote links", "Vorderpfote rechts", "Hinterpfote links", "Hinterpfote rechts"),
        ("linker Vorderfuß", "rechter Vorderfuß", "linker Hinterfuß", "rechter Hinterfuß"),
        ("vorne_links", "vorne_rechts", "hinten_links", "hinten_rechts"),
        # VL and VR were left out, and nothing said so, for HL and HR are names of pawnb's own
        ("VL", "VR", "HL", "HR"),
        ("Pfote_VL", "Pfote_VR", "Pfote_HL", "Pfote_HR"),
        ("patte avant gauche", "patte avant droite", "patte arrière gauche",
         "patte arrière droite"),
        ("sabot_ant\u00e9rieur_gauche", "sabot_anterieur_droit", "sabot_poste\u0301rieur_gauche",
         "sabot_posterieur_droit"),
        ("patte_AVG", "patte_AVD", "patte_ARG", "patte_ARD"),
        ("pata delantera izquierda", "pata delantera derecha", "pata trasera izquierda",
         "pata trasera derecha"),
        # horses: the near side is the left one
        ("Nearforefoot", "Offforefoot", "Nearhindfoot", "Offhindfoot"),
        ("Nearside fore", "Offside fore", "Nearside hind", "Offside hind"),
        ("near_front_hoof", "off_front_hoof", "near_hind_hoof", "off_hind_hoof"),
        ("foreleft", "foreright", "hindleft", "hindright"),
        ("leftfront", "rightfront", "lefthind", "righthind"),
        # forelimb and hindlimb: those of the right side were left out, and nothing said so
        ("L_FL", "R_FL", "L_HL", "R_HL"),
        ("left FL", "right FL", "left HL", "right HL"),
        ("LFL", "RFL", "LHL", "RHL"),
        ("LFL", "RFL", "LBL", "RBL"),
    ],
)  # fmt: skip
def test_feet_are_found_by_names_in_other_words(names):
    assert guess_legs([*names, "Nase"]) == in_order(*names)


@pytest.mark.parametrize(
    "points",
    [
        ["near_fore", "near_hind", "far_fore", "far_hind"],  # of the camera
        ["near_fore_paw", "near_hind_paw"],
        ["VL", "VR", "nose"],  # letters mean something only with those of all four legs
        ["patte_AVG", "patte_AVD"],
        ["Spitze der Pfote", "Pfote vorne"],
        ["wrist_L", "wrist_R", "ankle_L", "ankle_R"],  # a person has them as well
        ["mano izquierda", "pie derecho"],
    ],
)
def test_names_that_may_mean_something_else_are_not_guessed(points):
    assert guess_legs(points) == {}


def test_letters_of_another_language_do_not_change_those_that_are_understood():
    points = ["FL", "FR", "HL", "HR", "VL", "VR"]
    assert guess_legs(points) == in_order(*points[:4])


def test_a_foot_whose_side_is_mistyped_is_overlooked_aloud():
    points = ["forepaw_right", "forepaw_lef", "hindpaw_left"]
    legs = guess_legs(points)
    assert set(legs.values()) == {"forepaw_right", "hindpaw_left"}
    assert overlooked_points(points, legs) == ["forepaw_lef"]
    assert overlooked_points(["Vorderpfote"], {}) == ["Vorderpfote"]


@pytest.mark.parametrize(
    "names",
    [
        ("rightforepaw", "righthindpaw", "leftforepaw", "lefthindpaw"),
        ("forepawright", "hindpawright", "forepawleft", "hindpawleft"),
        ("frontrightpaw", "backrightpaw", "frontleftpaw", "backleftpaw"),
    ],
)
def test_names_in_one_word_are_read(names):
    assert guess_legs(names) == dict(zip(("FR", "HR", "FL", "HL"), names, strict=True))


def test_points_that_are_as_much_the_foot_of_a_leg_are_told():
    # one picture with a view from the side and one from below, as mirror mice have
    points = ["paw1LH_top", "paw2LF_top", "nose_top", "paw1LH_bot", "paw2LF_bot", "nose_bot"]
    legs = guess_legs(points)
    assert legs == {"FL": "paw2LF_top", "HL": "paw1LH_top"}
    assert rival_points(points, legs) == ["paw1LH_bot", "paw2LF_bot"]
    assert any("paw1LH_bot, paw2LF_bot: by name" in note for note in notes_on_legs(points, legs))
    # a joint further in is none, in whichever order they are
    points = ["hindleg_R", "hindpaw_R", "FL", "FL_wrist"]
    legs = guess_legs(points)
    assert legs == {"FL": "FL", "HR": "hindpaw_R"}
    assert rival_points(points, legs) == []


def test_the_example_of_a_leg_is_one_that_it_may_be():
    def said(*points):
        tracks = make_tracks(np.arange(3), list(points), fps=100.0)
        with pytest.raises(InputError) as caught:
            choose_legs(tracks)
        return str(caught.value)

    assert said("Nose", "Front paw tao", "Hind paw tao").endswith("--legs FR='Front paw tao'.")
    assert said("pt1", "snout", "tailbase").endswith("--legs HR=pt1.")
    # an animal on two legs: its left foot is no right one
    assert said("left_foot", "right_foot").endswith("--legs HL=left_foot HR=right_foot.")
    assert said("RBigToe", "LBigToe", "Nose").endswith("--legs HR=RBigToe HL=LBigToe.")


def test_legs_of_a_trial_are_the_points_that_it_names_and_no_others():
    tracks = make_tracks(np.arange(3), ["FR", "FL", "HR"], fps=100.0)

    def chosen(**legs):
        trial = Trial(
            kind="tracks", name="t", fps=100.0, animal=Animal(id="a"), tracks_file="a.csv",
            tracks_legs=legs,
        )  # fmt: skip
        return choose_legs(tracks, trial=trial), choose_legs(tracks, trial=trial, legs=list(legs))

    # names in the file that were exchanged are put right, and not left as they are
    assert chosen(FR="FL", FL="FR") == ({"FR": "FL", "FL": "FR"},) * 2
    with pytest.raises(InputError, match=r"leg 'FR': the tracks have no point 'paw FR'; they hav"):
        chosen(FR="paw FR")
