"""The stages of every tracker, as they are drawn on the page of methods.

A table: what a diagram shows is written here and nowhere else. Modules and types are named from the
diagram's package, or in full where they are elsewhere; that they exist, that the numbered text
below a diagram has the same stages, and that citations are among the sources is tested.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Stage:
    """A box.

    Parameters
    ----------
    title : str
        As in the numbered text.
    module : str
        Module or package.
    does : str
        What it does.
    cites : str
        Authors and year, as in the text.
    """

    title: str
    module: str
    does: str
    cites: str = ""


@dataclass(frozen=True)
class Row:
    """Stages beside each other, and the type that they pass on.

    Parameters
    ----------
    stages : tuple of Stage
        One, or several that do not wait for each other.
    gives : str
        Module and class of what goes on from here; several with commas between them.
    """

    stages: tuple[Stage, ...]
    gives: str


@dataclass(frozen=True)
class Loop:
    """An arrow back.

    Parameters
    ----------
    begin, end : str
        Titles of the stages that it leaves and enters.
    says : str
        How often, or until when.
    through : Stage, optional
        A stage on the way back.
    takes, gives : str
        Modules and classes of what goes back: from ``begin``, and out of ``through``.
    """

    begin: str
    end: str
    says: str
    through: Stage | None = None
    takes: str = ""
    gives: str = ""


@dataclass(frozen=True)
class Diagram:
    """A tracker.

    Parameters
    ----------
    title : str
        For who does not see it.
    package : str
        From where modules are named.
    begins, ends : str
        What comes in and goes out.
    rows : tuple of Row
        From top to bottom.
    loops : tuple of Loop
        The inner one first.
    """

    title: str
    package: str
    begins: str
    rows: tuple[Row, ...]
    ends: str
    loops: tuple[Loop, ...] = ()

    @property
    def stages(self) -> list[Stage]:
        """All boxes, those on a way back last."""
        through = [loop.through for loop in self.loops if loop.through is not None]
        return [stage for row in self.rows for stage in row.stages] + through

    @property
    def types(self) -> list[str]:
        """Modules and classes of all that is passed on."""
        back = [name for loop in self.loops for name in (loop.takes, loop.gives)]
        given = [name for row in self.rows for name in row.gives.split(", ")]
        return [name for name in given + back if name]


def one(title: str, module: str, does: str, cites: str = "", *, gives: str) -> Row:
    """Return a row of one stage."""
    return Row((Stage(title, module, does, cites),), gives)


COLOUR = Diagram(
    "Paws that colour tells, method pawnb",
    "pawnb.core.paws.offline",
    "Views, clicks",
    (
        one("Scene", "scene", "What paws and their surroundings look like, by the clicks.",
            gives="scene.treadmill.Scene"),
        one("Detection", "detection.colour", "One pass over the video: ends of paw-coloured parts.",
            gives="detection.colour.detections.ColourDetections, "
                  "detection.colour.observations.Observations"),
        one("Triangulation", "association.network_flow.triangulation",
            "Detections of two views that meet are places in space.", "Abdel-Aziz & Karara 1971",
            gives="association.network_flow.triangulation.PointHypotheses"),
        one("Tracklets", "association.network_flow.tracklets",
            "Places that follow each other beyond doubt are joined.",
            gives="association.network_flow.tracklets.Tracklet"),
        one("Association", "association.network_flow",
            "Which tracklets belong to which point: network flow.", "Held & Karp 1971",
            gives="association.network_flow.assignment.Assignment"),
        one("Gap closing", "gap_closing", "Multiple hypothesis tracking between certain tracklets.",
            "Reid 1979", gives="gap_closing.state.GapClosing"),
        one("Smoothing", "smoothing", "The path of least jerk through what was measured.",
            "Rauch, Tung & Striebel 1965", gives="smoothing.tracks.SmoothedTracks"),
    ),
    "Tracks",
    (
        Loop("Smoothing", "Association", "until nothing changes",
             Stage("Stride model", "stride", "Cycle, stance, swing.", "Flash & Hogan 1985"),
             "smoothing.tracks.SmoothedTracks", "stride.model.StrideModel"),
    ),
)  # fmt: skip

LANDMARKS = Diagram(
    "Landmarks, method pawnb",
    "pawnb.core.paws.offline",
    "Views, clicks",
    (
        one("Choice", "landmarks.tracks", "Points that are no paws, by their names or as told.",
            gives="pawnb.core.paws.layout.Placement"),
        one("Templates", "landmarks.template_tracking",
            "Optical flow, then aligned with the patch as it was clicked.",
            "Lucas & Kanade 1981; Bouguet 2001",
            gives="landmarks.template_tracking.TemplateTracker"),
        one("Both ways", "landmarks.backward_tracking",
            "The same from later clicks back to earlier ones.",
            gives="landmarks.template_tracking.TemplateTracker"),
        one("Joining", "landmarks.tracks", "What the views have seen, joined to one smooth path.",
            "Rauch, Tung & Striebel 1965", gives="smoothing.tracks.SmoothedTracks"),
    ),
    "Tracks",
)  # fmt: skip

LEARNT = Diagram(
    "Points of any animal, method pawnb",
    "pawnb.core.paws.offline",
    "Views, clicks",
    (
        one("Scene", "scene", "Each view as a stack of pictures in the body's frame, and its flow.",
            "Kroeger et al. 2016", gives="scene.stack.BodyStack"),
        Row((
            Stage("Motion", "detection.motion", "Optical flow from every click.",
                  "Kalal et al. 2010"),
            Stage("Predictions", "detection.predictions", "Of other tools, where a trial has them.",
                  "Baum et al. 1970"),
            Stage("Point tracker", "detection.point_tracking",
                  "A trained network, where a trial names one.", "Doersch et al. 2023"),
            Stage("Appearance", "detection.appearance", "A classifier learnt in the recording."),
        ), "association.associate.ViewEvidence"),
        one("Association", "association",
            "A hidden Markov model for each point; points and views are compared.",
            "Rabiner 1989; Koller & Friedman 2009",
            gives="association.forward_backward.Posterior"),
        one("Estimates", "association.estimates", "In each frame, the mean of the highest mode.",
            gives="association.estimates.Estimates"),
        one("Calibration", "quality.calibration",
            "The probability that each is right, and its standard deviation.",
            gives="pipeline.ViewTrack"),
    ),
    "Tracks",
    (
        Loop("Estimates", "Appearance", "once more",
             Stage("Learning again", "self_training.pseudo_labels", "Frames in which all agree."),
             "association.estimates.Estimates", "detection.appearance.TrainingFrame"),
    ),
)  # fmt: skip

MAGHSOUDI = Diagram(
    "Paws, method paper: Haji Maghsoudi, Vahedipour & Spence 2019",
    "pawnb.core.paws.maghsoudi2019",
    "Views, clicks",
    (
        one("Prediction", "pawnb.core.kalman",
            "A Kalman filter in space says where each paw should be.",
            gives="pawnb.core.kalman.State"),
        one("Superpixels", "pawnb.core.paws.superpixels",
            "SLIC of a sub-image about the prediction, in each view.", "Achanta et al. 2012",
            gives="pawnb.core.paws.superpixels.Superpixels"),
        one("Fusion", "fusion", "Eight features, weighted; the three best superpixels are kept.",
            "Eq. 3 to 6", gives="frame_result.Detection"),
        one("Collisions", "collisions",
            "A stride template predicts through collisions of paws of one side.",
            "Eq. 7 to 9, Algorithms 3 and 4", gives="collision_flags.Resolved"),
        one("Jumps", "collisions",
            "Too large a reprojection error: the next best superpixels are tried.",
            "Algorithm 3", gives="collision_flags.Undone"),
        one("Reconstruction", "run", "Triangulation of all views; the filter is updated.",
            "Abdel-Aziz & Karara 1971", gives="frame_result.FrameResult"),
    ),
    "Tracks",
    (Loop("Reconstruction", "Prediction", "next frame", takes="pawnb.core.kalman.State"),),
)  # fmt: skip

POSES = Diagram(
    "Poses, method pawnb",
    "pawnb.core.pose",
    "View, empty scene",
    (
        one("Presence", "presence", "Frames that differ from the empty scene hold the animal.",
            "Pullar 2009", gives="presence.Presence"),
        one("Start pose", "start_proposal", "From the silhouette, or posed by hand.",
            gives="poses.Poses"),
        one("Painting", "fit.rendering", "A stick animal, painted with what is learnt of its look.",
            gives="fit.fitter.FrameFitter"),
        one("Fit", "fit.sequence", "Gauss-Newton from the pose expected, frame to frame both ways.",
            gives="fit.candidates.candidate_sets.LegCandidates"),
        one("Association", "fit.candidates",
            "The smoothest path of a side's legs through the candidates.", "Viterbi 1967",
            gives="fit.state.PoseFitState"),
        one("Smoothing", "fit.sequence.final_fit",
            "All frames together; standard deviations from the curvature.",
            gives="fit.sequence.final_fit.FinalFit"),
    ),
    "PoseTrack",
    (
        Loop("Association", "Painting", "once, if legs are hidden",
             Stage("Learning", "fit.learning", "Wings, and how legs are held."),
             "fit.state.PoseFitState", "fit.fitter.FrameFitter"),
    ),
)  # fmt: skip

SPACE = Diagram(
    "Poses in space, method pawnb",
    "pawnb.core.pose.space",
    "PoseTrack of one view, a second view, calibration",
    (
        one("Ground", "fitter", "The lowest height that the animal reaches in the second view.",
            "Abdel-Aziz & Karara 1971", gives="fitter.SpaceFitter"),
        one("Learning", "learn", "Its appearance and proportions, from some frames.",
            gives="model.SpaceModel"),
        one("Heights", "pipeline", "Each frame alone, then from its neighbours, then with them.",
            "Pullar 2009, Eq. 5.1", gives="track.SpaceTrack"),
        one("Correction", "first_view", "The first view's pose agrees with the joints in space.",
            gives="pawnb.core.pose.track_result.PoseTrack"),
    ),
    "Tracks",
)  # fmt: skip

PULLAR = Diagram(
    "Poses, method paper: Pullar 2009",
    "pawnb.core.pose.pullar2009",
    "View, empty scene, a pose",
    (
        one("Likelihood", "likelihood", "Background or subject, by a Gaussian of the empty frames.",
            gives="energy.FrameCosts"),
        one("Shape prior", "sticks", "How far each pixel is from the stick animal.", "Eq. 3.15",
            gives="sticks.Sticks"),
        one("Energy", "mincut", "Its least value for a pose is an exact min-cut.",
            "Bray, Kohli & Torr 2006", gives="energy.Cut"),
        one("Search", "inference", "Body, then limbs, by angle steps that become finer.",
            "section 3.4.2", gives="inference.FramePose"),
    ),
    "PoseTrack",
    (
        Loop("Search", "Shape prior", "until energy falls no more"),
        Loop("Search", "Likelihood", "next frame"),
    ),
)  # fmt: skip

DIAGRAMS = {
    "paws-by-colour": COLOUR, "landmarks": LANDMARKS, "points-of-any-animal": LEARNT,
    "paws-2019": MAGHSOUDI, "poses": POSES, "poses-in-space": SPACE, "poses-2009": PULLAR,
}  # fmt: skip
"""Name on the page of methods to the diagram."""
