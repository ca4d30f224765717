"""Calibrations of other programs, both ways: where cameras show points. See ``formats.py``."""

from __future__ import annotations

import importlib
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
from format_programs import argus_shows, argus_writes_coefficients

from pawnb.core.dlt import fit_dlt, project
from pawnb.io.cameras import Camera, coefs_of_cameras, read_cameras
from pawnb.io.cameras_out import write_cameras, write_mayacam, write_opencv_cameras
from pawnb.io.coefs import read_coefs
from pawnb.workflow.calibration.calibrate_file import calibrate_from_file
from pawnb.workflow.calibration.export_file import export_calibration


def aniposelib(folder: Path) -> tuple[str, str]:
    """By aniposelib: where its cameras show points, with the distortion of their lenses."""
    lib = importlib.import_module("aniposelib.cameras")
    xyz = np.random.default_rng(0).uniform(-40, 40, (50, 3))
    group = lib.CameraGroup(
        [
            lib.Camera(
                name=name, size=[640, 480], rvec=[0.0, angle, 0.0], tvec=[0.0, 0.0, 400.0],
                matrix=[[900.0, 0.0, 320.0], [0.0, 900.0, 240.0], [0.0, 0.0, 1.0]],
                dist=[-0.2, 0.05, 0.0, 0.0, 0.0],
            )
            for name, angle in (("a", 0.4), ("b", -0.4))
        ]
    )  # fmt: skip
    group.dump(str(folder / "theirs.toml"))
    cameras = read_cameras(folder / "theirs.toml")
    read = max(float(np.abs(shown(c, xyz) - g.project(xyz)[:, 0]).max())
               for c, g in zip(cameras, group.cameras, strict=True))  # fmt: skip
    again = lib.CameraGroup.load(str(write_cameras(cameras, folder / "ours.toml")))
    write = max(float(np.abs(c.project(xyz) - g.project(xyz)).max())
                for c, g in zip(again.cameras, group.cameras, strict=True))  # fmt: skip
    return f"{read:.1g}", f"{write:.1g}"


def shown(camera: Camera, xyz: np.ndarray) -> np.ndarray:
    """Return where pawnb shows points: by DLT coefficients, then bent as the lens does."""
    coefs, origin = coefs_of_cameras([camera])
    uv = project(coefs[:, 0], xyz - origin)[:, 0]
    rays = np.linalg.solve(camera.matrix, np.column_stack([uv, np.ones(len(uv))]).T).T
    return cv2.projectPoints(
        rays, np.zeros(3), np.zeros(3), camera.matrix, np.array(camera.distortion)
    )[0][:, 0]


def opencv(folder: Path) -> tuple[str, str]:
    """By OpenCV's FileStorage and projection."""
    path, angle = folder / "cameras.yaml", np.array([0.1, 0.4, 0.0])
    K, t = np.array([[900.0, 0, 320], [0, 900, 240], [0, 0, 1]]), np.array([3.0, 2.0, 400.0])
    D = np.array([[-0.2, 0.05, 0.001, 0.0, 0.0]])
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    for name, value in (("K_a", K), ("dist_a", D), ("R_a", angle.reshape(3, 1)),
                        ("T_a", t.reshape(3, 1))):  # fmt: skip
        storage.write(name, value)
    storage.release()
    xyz = np.random.default_rng(0).uniform(-40, 40, (50, 3))
    (camera,) = read_cameras(path)
    expected = cv2.projectPoints(xyz, angle, t, K, D)[0][:, 0]
    read = np.abs(shown(camera, xyz) - expected).max()
    ours = write_opencv_cameras([camera], folder / "ours.yaml")
    storage = cv2.FileStorage(str(ours), cv2.FILE_STORAGE_READ)
    R, T, matrix, bent = (storage.getNode(f"{k}_a").mat() for k in ("Rot", "T", "K", "dist"))
    again = cv2.projectPoints(xyz, cv2.Rodrigues(R)[0], T, matrix, bent)[0][:, 0]
    return f"{read:.1g}", f"{np.abs(again - expected).max():.1g}"


def pose2sim(folder: Path) -> tuple[str, str]:
    """By Pose2Sim: its own writer, its own reader and projection; lenses bend by OpenCV's model."""
    calibration, common = (importlib.import_module(f"Pose2Sim.{part}")
                           for part in ("calibration", "common"))  # fmt: skip
    angle, t = np.array([0.1, 0.4, 0.0]), np.array([3.0, 2.0, 400.0])
    K = np.array([[900.0, 0, 320], [0, 900, 240], [0, 0, 1]])
    D = np.array([-0.2, 0.05, 0.001, 0.0])
    path = folder / "Calib_scene.toml"
    calibration.toml_write(path, ["a"], [[640.0, 480.0]], [D], [K], [angle], [t])
    xyz = np.random.default_rng(0).uniform(-40, 40, (50, 3))
    cameras = read_cameras(path)
    expected = cv2.projectPoints(xyz, angle, t, K, D)[0][:, 0]
    read = np.abs(shown(cameras[0], xyz) - expected).max()
    ours = write_cameras(cameras, folder / "ours.toml")
    (P,), straight = common.computeP(ours), cv2.projectPoints(xyz, angle, t, K, np.zeros(4))[0]
    again = np.array([common.reprojection([P], np.array([*point, 1.0])) for point in xyz])[..., 0]
    bent = common.retrieve_calib_params(ours)["dist"][0]
    write = max(np.abs(again - straight[:, 0]).max(), np.abs(bent[:4] - D).max())
    return f"{read:.1g}", f"{write:.1g}"


def xmalab(folder: Path) -> tuple[str, str]:
    """By OpenCV's projection, of a MayaCam file laid out as XMALab's source writes it."""
    angle, t = np.array([0.1, 0.4, 0.0]), np.array([3.0, 2.0, 400.0])
    K = np.array([[900.0, 0, 320], [0, 900, 240], [0, 0, 1]])
    path = folder / "a.txt"
    parts = {
        "image size": [[640, 480]], "camera matrix": K.tolist(),
        "rotation": cv2.Rodrigues(angle)[0].tolist(), "translation": t.reshape(3, 1).tolist(),
    }  # fmt: skip
    path.write_text("".join(
        f"{head}\n" + "\n".join(",".join(f"{x:.12g}" for x in row) for row in rows) + "\n\n"
        for head, rows in parts.items()
    ))  # fmt: skip
    xyz = np.random.default_rng(0).uniform(-40, 40, (50, 3))
    (camera,) = read_cameras(path)
    expected = cv2.projectPoints(xyz, angle, t, K, np.zeros(4))[0][:, 0]
    read = np.abs(shown(camera, xyz) - expected).max()
    exact = replace(camera, rotation=cv2.Rodrigues(angle)[0])  # theirs are 12 digits
    # Autoscoper, which takes these files from XMALab, finds numbers by the number of their line
    lines = write_mayacam(exact, folder / "ours.txt").read_text().split("\n")
    matrix, R = (
        np.array([line.split(",") for line in lines[first : first + 3]], dtype=float)
        for first in (4, 9)
    )
    moved = np.array(lines[14:17], dtype=float)
    again = cv2.projectPoints(xyz, cv2.Rodrigues(R)[0], moved, matrix, np.zeros(4))[0][:, 0]
    write = np.abs(again - expected).max()
    return f"{read:.1g} (source)", f"{write:.1g} (source)"


def coefficients(
    folder: Path, program: str, *, digits: int = 17, known_from: str = "described"
) -> tuple[str, str]:
    """DLT coefficients of points as a program counts its pixels, both ways.

    Parameters
    ----------
    folder : Path
        Where files go.
    program : str
        As for ``pawnb calibrate --from``.
    digits : int
        Significant digits that the program writes.
    known_from : str
        How it is known what the program writes; empty where it writes itself.
    """
    K = np.array([[900.0, 0, 320], [0, 900, 240], [0, 0, 1]])
    angle, t = np.array([0.1, 0.4, 0.0]), np.array([3.0, 2.0, 400.0])
    xyz = np.random.default_rng(0).uniform(-40, 40, (50, 3))
    uv = cv2.projectPoints(xyz, angle, t, K, np.zeros(4))[0][:, 0]
    moved = {
        "dltdv": uv + 1.0,
        "xmalab": np.column_stack([uv[:, 0] + 1.0, 480.0 - uv[:, 1]]),
        "easywand": np.column_stack([uv[:, 0] + 1.0, 480.0 - uv[:, 1]]),
        "argus": np.column_stack([uv[:, 0], 480.0 - uv[:, 1]]),
    }[program]
    theirs = folder / "theirs.csv"
    if program == "argus":
        argus_writes_coefficients(fit_dlt(xyz, moved).coefs, folder / "a").rename(theirs)
    else:
        lines = [f"{x:.{digits}g}" for x in fit_dlt(xyz, moved).coefs]
        theirs.write_text("\n".join(lines) + "\n")
    heights = None if program == "dltdv" else [480]
    calibrate_from_file(theirs, out=folder / "ours.csv", program=program, heights_px=heights)
    ours = read_coefs(folder / "ours.csv", ["cam1"])
    read = np.abs(project(ours[:, 0], xyz)[:, 0] - uv).max()
    rotation = cv2.Rodrigues(angle)[0]
    camera = Camera(name="a", matrix=K, distortion=(), rotation=rotation, translation=t)
    write_opencv_cameras([camera], folder / "a.yaml")
    written = folder / "written.csv"
    export_calibration(folder / "a.yaml", out=written, to=program, heights_px=heights)
    if program == "argus":
        seen = argus_shows(written, xyz)
    else:
        L = np.loadtxt(written, delimiter=",")
        P = np.append(L, 1.0).reshape(3, 4) @ np.column_stack([xyz, np.ones(len(xyz))]).T
        seen = (P[:2] / P[2]).T
    write = np.abs(seen - moved).max()
    told = f" ({known_from})" if known_from else ""
    return f"{read:.1g}{told}", f"{write:.1g}{told}"
