"""What the files of a gait analysis are, in a line each."""

from __future__ import annotations

FILES = {
    "events.csv": "AEP, PEP, touch-down and lift-off of each leg",
    "strides.csv": "one row a stride, with all its measures",
    "phases.csv": "one row a stride and pair of legs",
    "phase_summary.csv": "mean phases with intervals and tests; the pattern of each pair",
    "dropped.csv": "what was left out, and why",
    "trials.csv": "who was analysed: groups, covariates, strides, what was dropped",
    "animals.csv": "every measure, leg by leg, counting animals",
    "groups.csv": "differences between groups or conditions, with intervals",
    "curve_clusters.csv": "stretches of the stride in which curves differ between groups",
    "legs.csv": "whether measures differ between legs",
    "steadiness.csv": "how steady each trial was",
    "stride_durations.csv": "whether legs keep one rhythm, trial by trial",
    "against_speed.csv": "measures against speed (Pullar 2009, Table 4.5)",
    "speed_residuals.csv": "what is left of measures once a line on speed is taken away",
    "phase_speed.csv": "what speed does to phases, within animals",
    "scaling.csv": "measures against size over animals (Pullar 2009, Table 4.3)",
    "expected_exponents.csv": "exponents of size beside expected ones (Pullar 2009, Table 4.4)",
    "joint_ranges.csv": "ranges of the joints (Pullar 2009, Table 4.6)",
    "body_angles.csv": "roll, pitch and yaw of the body",
    "support.csv": "which feet are on the ground, moment by moment",
    "support_shares.csv": "share of time with so many feet on the ground",
    "patterns.csv": "distances to ideal gaits",
    "coupling.csv": "coupling between legs",
    "notes.csv": "every note and warning of the run",
    "methods.txt": "a paragraph for the methods section",
    "provenance.json": "versions, settings, checksums: the recipe of every file here",
}

FIGURES = {
    "estimation_": "Groups: each animal, means, differences with intervals",
    "curves_": "Groups: curves over the stride, and where they differ",
    "measure_heat_map": "All measures of all animals, from their mean",
    "measure_components": "Principal components of all measures",
    "phase_rose": "Phases of pairs of legs, with mean and interval",
    "phase_histogram": "Histograms of phases",
    "phase_speed": "Phases against speed",
    "phase_density": "Phases of two pairs of legs at every instant",
    "hildebrand_diagram": "Hildebrand's diagram: duty factor and lag of fore behind hind",
    "stepping_pattern": "Stepping pattern",
    "support_shares": "Share of time with so many feet on the ground",
    "pattern_distances": "Distances to ideal gaits",
    "against_": "Measures against speed or size",
    "species_": "Own animals among other species (Pullar 2009, Figs. 4.3 and 4.4)",
    "stride_average": "Averages over the stride",
    "phase_plane": "Phase plane",
    "aligned_acceleration": "Acceleration, aligned at the events",
    "joint_ranges": "Ranges of the joints",
    "template_fit": "The stride template fitted to a paw",
    "summary_": "One page an animal",
    "gait_diagram": "Gait diagram: stance of each leg in time",
    "paths_3d": "Paths of the feet in space",
}
"""What a figure shows, by the beginning of its name; in the order of a page."""


def figure_order(name: str) -> tuple[int, str]:
    """Return where a figure stands on a page: those of all animals first, then trial by trial."""
    last = name.rpartition("/")[2]
    places = [k for k, start in enumerate(FIGURES) if last.startswith(start)]
    return (places[0] if places else len(FIGURES), last)


def figure_words(name: str) -> str:
    """Return what a figure shows, by the beginning of its name."""
    said = next((words for start, words in FIGURES.items() if name.startswith(start)), "Figure")
    return f"{said} ({name})"
