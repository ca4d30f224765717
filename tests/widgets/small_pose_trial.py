"""A small trial of kind ``pose``: one painted spider that stands still, exactly known.

Frames 0 and 1 are empty. The spider is a generic one (built-in species ``spider``) in its
natural pose, seen from above at 2 px per mm, heading 30 degrees down to the right.
"""

import av
import cv2
import numpy as np

from pawnb.core.pose.poses import joint_positions, natural_pose
from pawnb.core.pose.species_file import load_species

WIDTH, HEIGHT, N_FRAMES, EMPTY = 320, 240, 6, 2
XY, HEADING, SCALE = (150.0, 118.0), 30.0, 2.0
SPECIES = load_species("spider")


def truth():
    """The pose in every frame with the spider."""
    return natural_pose(SPECIES, frame=EMPTY, xy=XY, heading_deg=HEADING, scale=SCALE)


def picture(frame):
    """Draw one frame, (H, W) grey uint8: twice as fine, then reduced."""
    fine = np.full((2 * HEIGHT, 2 * WIDTH), 200, np.uint8)
    if frame >= EMPTY:
        pose = truth()
        for leg, places in zip(SPECIES.legs, joint_positions(SPECIES, pose)[0], strict=True):
            for k in reversed(range(len(leg.segments))):
                ends = [tuple(np.round(16 * (2 * p + 0.5)).astype(int)) for p in places[k : k + 2]]
                thick = max(2, round(2 * SCALE * leg.widths[k]))
                cv2.line(fine, *ends, 60 + 8 * k, thick, cv2.LINE_AA, 4)
        turn = np.radians(HEADING)
        for part in SPECIES.body:
            at = np.array(XY) + SCALE * part.centre[0] * np.array([np.cos(turn), np.sin(turn)])
            centre = tuple(np.round(16 * (2 * at + 0.5)).astype(int))
            axes = tuple(np.round(16 * SCALE * np.array([part.length, part.width])).astype(int))
            cv2.ellipse(fine, centre, axes, HEADING, 0, 360, 50, -1, cv2.LINE_AA, 4)
    picture = cv2.resize(fine, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA)
    noise = np.random.default_rng(frame).normal(0, 2, picture.shape)
    return np.clip(picture + noise, 0, 255).round().astype(np.uint8)


def write_pose_trial(folder):
    """Write video and trial.toml, without a start pose; return the path of trial.toml."""
    folder.mkdir(parents=True, exist_ok=True)
    with av.open(str(folder / "top.avi"), "w") as file:
        stream = file.add_stream("ffv1", rate=25)
        stream.width, stream.height, stream.pix_fmt = WIDTH, HEIGHT, "gray"
        for frame in range(N_FRAMES):
            file.mux(stream.encode(av.VideoFrame.from_ndarray(picture(frame), "gray")))
        file.mux(stream.encode())
    (folder / "trial.toml").write_text(
        '[trial]\nkind = "pose"\nname = "small"\nfps = 125.0\n'
        '[animal]\nid = "s1"\nspecies = "spider"\n'
        f'[[views]]\nname = "top"\nvideo = "top.avi"\nbackground_frames = [0, {EMPTY}]\n'
        f'[calibration]\npx_per_unit = {SCALE}\nunit = "mm"\n'
        '[start]\npose = "start_pose.csv"\n'
    )
    return folder / "trial.toml"
