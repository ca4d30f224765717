"""A paper's name of a setting is answered with ours, wherever it is typed."""

import dataclasses

import pytest

from pawnb.core.paws.maghsoudi2019.settings import PUBLISHED_NAMES as PAW_NAMES
from pawnb.core.paws.maghsoudi2019.settings import Maghsoudi2019Settings
from pawnb.core.paws.offline.settings import FORMER_NAMES, OfflineSettings
from pawnb.core.pose.pullar2009.settings import PUBLISHED_NAMES as POSE_NAMES
from pawnb.core.pose.pullar2009.settings import Pullar2009Settings
from pawnb.errors import InputError
from pawnb.schema import add_provenance, make_tracks
from pawnb.trial import Animal, Trial, View
from pawnb.workflow.evaluation.compared import settings_by_method
from pawnb.workflow.tracking.methods import method_of_tracks, tracker_settings
from pawnb.workflow.tracking.published_names import refuse_published_names

TRIAL = Trial(
    kind="paws",
    name="t",
    fps=250.0,
    animal=Animal(id="a"),
    views=(View(name="cam1", video="a.avi"),),
)


@pytest.mark.parametrize("name", ["Start_Frame_Collision", "NumSLIC", "Collision_Threshold"])
@pytest.mark.parametrize("method", ["pawnb", "paper"])
def test_a_tracker_says_our_name(name, method):
    said = rf"^setting '{name}' is the paper's {name}, which is '{PAW_NAMES[name]}' here"
    with pytest.raises(InputError, match=said):
        tracker_settings(TRIAL, method=method, settings={name: "3"})
    with pytest.raises(InputError, match=said):
        tracker_settings(dataclasses.replace(TRIAL, tracking={name: 3}), method=method)


def test_a_comparison_says_our_name():
    with pytest.raises(InputError, match="is the paper's NumSLIC, which is 'n_superpixels'"):
        settings_by_method({"paper.NumSLIC": 5}, ["pawnb", "paper"])


@pytest.mark.parametrize("name", ["numslic", "num_slic", "NUM-SLIC"])
def test_letters_may_be_cased_and_joined_otherwise(name):
    with pytest.raises(InputError, match=f"{name}.*n_superpixels"):
        refuse_published_names([name])


@pytest.mark.parametrize(
    ("names", "settings", "kind"),
    [(PAW_NAMES, Maghsoudi2019Settings, "paws"), (POSE_NAMES, Pullar2009Settings, "pose")],
)
def test_our_names_are_settings_and_are_not_refused(names, settings, kind):
    known = [field.name for field in dataclasses.fields(settings)]
    assert set(names.values()) <= set(known)
    refuse_published_names([*known, "windw_u_px"], kind=kind)


@pytest.mark.parametrize("name", FORMER_NAMES)
def test_a_former_name_is_answered_with_the_present_one(name):
    said = f"^setting '{name}' is called '{FORMER_NAMES[name]}' now"
    with pytest.raises(InputError, match=said):
        tracker_settings(TRIAL, settings={name: 3})
    with pytest.raises(InputError, match=said):
        tracker_settings(dataclasses.replace(TRIAL, tracking={name: 3}))
    assert FORMER_NAMES[name] in {field.name for field in dataclasses.fields(OfflineSettings)}


def test_tracks_that_record_former_names_are_gone_on_with():
    recorded = {"hide_cost": 2.5, "looks": 1, "acceleration": 400.0}
    tracks = add_provenance(
        make_tracks([0], ["FR"], fps=250.0), step="track", method="pawnb", settings=recorded
    )
    tracker, settings = method_of_tracks(TRIAL, tracks)
    assert tracker.name == "pawnb"
    assert settings == OfflineSettings(occlusion_onset_cost=2.5, n_iterations=1, acceleration=400.0)
