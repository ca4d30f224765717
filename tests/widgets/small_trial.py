"""A small trial for the widgets: two points glide past three calibrated views.

Motion: FR goes along x by 8 mm a frame, HR stands still, both without any noise, so
every image position is known exactly. Cameras look from infinitely far away (L9..L11 = 0):

    cam1: u = x + 60,       v = 300 - z      (from the side)
    cam2: u = x + 0.5 y,    v = 280 - z      (turned)
    cam3: u = x + 40,       v = 80 + y       (from above)

Each picture carries its frame number as a bar code of black and white squares in its top
left corner, so that a test can tell from pixels which frame is on the screen.
"""

import av
import numpy as np

from pawnb.schema import ORIGIN_CODE, make_tracks

WIDTH, HEIGHT, N_FRAMES, FPS = 640, 360, 40, 250.0
SQUARE, BITS = 20, 6
POINTS = {"cam1": ("FR", "HR"), "cam2": ("FR", "HR"), "cam3": ("FR",)}
COEFS = np.array(
    [
        [1, 0, 0, 60, 0, 0, -1, 300, 0, 0, 0],
        [1, 0.5, 0, 0, 0, 0, -1, 280, 0, 0, 0],
        [1, 0, 0, 40, 0, 1, 0, 80, 0, 0, 0],
    ]
).T


def place(frame):
    """Where FR and HR are in space, mm: shape (2, 3)."""
    return np.array([[50.0 + 8 * frame, 40, 30], [150.0, 120, 90]])


def seen(frame):
    """Image positions (view, point, 2), px, by the three formulas above."""
    x, y, z = place(frame).T
    return np.stack(
        [
            np.stack([x + 60, 300 - z], axis=1),
            np.stack([x + 0.5 * y, 280 - z], axis=1),
            np.stack([x + 40, 80 + y], axis=1),
        ]
    )


def picture(frame, view):
    """Draw one frame, (H, W, 3) RGB uint8."""
    image = np.full((HEIGHT, WIDTH, 3), 90, np.uint8)
    for bit in range(BITS):
        image[:SQUARE, bit * SQUARE : (bit + 1) * SQUARE] = 255 * (frame >> bit & 1)
    v, u = np.mgrid[:HEIGHT, :WIDTH]
    for (pu, pv), colour in zip(seen(frame)[view], ((230, 60, 60), (60, 60, 230)), strict=True):
        image[(u - pu) ** 2 + (v - pv) ** 2 < 8**2] = colour
    return image


def describe_trial(folder):
    """Write calibration and trial.toml, without videos; return the path of trial.toml."""
    folder.mkdir(parents=True, exist_ok=True)
    sections = [f'[trial]\nname = "small"\nfps = {FPS}\n[animal]\nspecies = "mouse"\n']
    for name, points in POINTS.items():
        listed = ", ".join(f'"{p}"' for p in points)
        sections.append(f'[[views]]\nname = "{name}"\nvideo = "{name}.avi"\npoints = [{listed}]\n')
    sections.append('[calibration]\ndlt = "DLTcoefs.csv"\n[start]\npoints = "start.csv"\n')
    np.savetxt(folder / "DLTcoefs.csv", COEFS, delimiter=",")
    (folder / "trial.toml").write_text("\n".join(sections))
    return folder / "trial.toml"


def write_trial(folder):
    """Write the whole trial with its videos; return the path of trial.toml."""
    path = describe_trial(folder)
    for k, name in enumerate(POINTS):
        with av.open(str(folder / f"{name}.avi"), "w") as file:
            stream = file.add_stream("mjpeg", rate=25)
            stream.width, stream.height, stream.pix_fmt = WIDTH, HEIGHT, "yuvj420p"
            stream.options = {"qscale": "3"}
            for frame in range(N_FRAMES):
                file.mux(stream.encode(av.VideoFrame.from_ndarray(picture(frame, k), "rgb24")))
            file.mux(stream.encode())
    return path


def true_tracks():
    """Tracks without error: measured where a view tracks the point, else missing."""
    tracks = make_tracks(range(N_FRAMES), ["FR", "HR"], fps=FPS, views=list(POINTS), unit="mm")
    tracks["position"].values[..., 0] = np.stack([place(f).T for f in range(N_FRAMES)])
    uv = np.stack([np.moveaxis(seen(f), 1, 2) for f in range(N_FRAMES)])  # (n, V, 2, P)
    uv[:, 2, :, 1] = np.nan  # cam3 does not track HR
    tracks["image_position"].values[..., 0] = uv
    there = np.isfinite(uv).all(axis=2)
    tracks["image_origin"].values[..., 0] = np.where(there, ORIGIN_CODE["measured"], 0)
    tracks["image_confidence"].values[..., 0] = np.where(there, 0.8, 0)
    tracks["origin"].values[:] = ORIGIN_CODE["measured"]
    tracks["confidence"].values[:] = 0.8
    tracks["residual"].values[:] = 0.0
    return tracks
