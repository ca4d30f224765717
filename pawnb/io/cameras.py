"""Calibrated cameras of other programs: matrix, lens, and where each stands.

All give what OpenCV does: a point X is at R X + t in the camera's own axes, its matrix makes
pixels of the straightened picture, and the distortion bends them to those that were filmed.
Pixels are of the whole, unmirrored picture, (0, 0) the centre of the top-left one.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from pawnb.arrays import FloatArray
from pawnb.errors import CalibrationError
from pawnb.files import parse_toml, read_text
from pawnb.schema.arguments import checked_arguments

_EXPECTED = (
    "calibrated cameras of Anipose, Pose2Sim or caliscope (.toml), OpenCV (.yaml, .yml) or XMALab "
    "(MayaCam 2.0, .txt)"
)
_COUNTS = (0, 4, 5, 8, 12, 14)
_MATRIX = re.compile(
    r"^(?P<indent> *)(?P<name>[\w.-]+): *!!opencv-matrix\s+rows: *(?P<rows>\d{1,3})\s+"
    r"cols: *(?P<cols>\d{1,3})\s+dt: *\w+\s+data: *\[(?P<data>[^\]]*)\]",
    re.MULTILINE,
)
_SECTION = re.compile(r"^(?P<name>[\w.-]+): *$", re.MULTILINE)
_INTRINSIC = ("camera_matrix", "cameraMatrix", "K", "M", "matrix", "intrinsic_matrix")
_DISTORTION = ("distortion_coefficients", "distCoeffs", "dist", "D", "distortions", "distortion")
_ROTATION = ("Rot", "R", "rvec", "rotation", "rotation_matrix")
_TRANSLATION = ("T", "tvec", "translation", "t")
_HEAD = ("image size", "camera matrix", "rotation", "translation")
_FAR = 1e-6
"""A camera nearer to the origin than this part of its distance to others has no L12 = 1."""


@dataclass(frozen=True, kw_only=True)
class Camera:
    """A calibrated camera.

    Parameters
    ----------
    name : str
        Its name.
    matrix : ndarray, shape (3, 3)
        Camera matrix, px.
    distortion : tuple of float
        Coefficients in OpenCV's order k1, k2, p1, p2, k3, ...; empty for none.
    rotation : ndarray, shape (3, 3)
        R of R X + t.
    translation : ndarray, shape (3,)
        t, in the unit of the calibration.
    size : tuple of int, optional
        Width and height of its picture, px.

    Examples
    --------
    >>> matrix = np.array([[800.0, 0.0, 320.0], [0.0, 800.0, 240.0], [0.0, 0.0, 1.0]])
    >>> camera = pawnb.io.Camera(name="cam1", matrix=matrix, distortion=(), rotation=np.eye(3),
    ...                          translation=np.array([0.0, 0.0, 500.0]), size=(640, 480))
    >>> camera.is_straight
    True
    """

    name: str
    matrix: FloatArray
    distortion: tuple[float, ...]
    rotation: FloatArray
    translation: FloatArray
    size: tuple[int, int] | None = None

    @property
    def is_straight(self) -> bool:
        """Whether its lens bends nothing."""
        return not any(self.distortion)


@checked_arguments
def read_cameras(path: str | Path, *more: str | Path) -> list[Camera]:
    """Read the calibrated cameras of another program.

    Parameters
    ----------
    path : str or Path
        ``calibration.toml`` of Anipose (aniposelib) or Pose2Sim, ``camera_array.toml`` of
        caliscope (camera 0 is called ``cam_0``, as its film is); ``.yaml`` of OpenCV's
        FileStorage, where names tell what a matrix is: ``K_cam1, dist_cam1, Rot_cam1`` (or
        ``R_cam1``), ``T_cam1`` (EasyMocap; rotations may be in ``extri.yml`` beside
        ``intri.yml``), ``M1, D1, M2, D2, R, T`` of a pair of cameras (OpenCV's stereo
        calibration), or a section a camera with ``camera_matrix, distortion_coefficients, R, T``;
        or a MayaCam 2.0 ``.txt`` of XMALab, which holds one camera.
    *more : str or Path
        Further files, one a camera.

    Returns
    -------
    list of Camera
        In the order of the files.

    Raises
    ------
    CalibrationError
        If a file is of another kind, or a camera lacks something or is none.

    Examples
    --------
    >>> path = pawnb.io.write_cameras(cameras, "calibration.toml")
    >>> [camera.name for camera in pawnb.io.read_cameras(path)]
    ['cam1', 'cam2']
    """
    paths = [Path(one) for one in (path, *more)]
    # intri.yml is read with extri.yml beside it: naming both is naming one
    paths = [one for i, one in enumerate(paths) if not set(_beside(one)) & set(paths[:i])]
    cameras = [camera for one in paths for camera in _read_file(one)]
    names = [camera.name for camera in cameras]
    twice = next((name for i, name in enumerate(names) if name in names[:i]), None)
    if twice is not None:
        raise CalibrationError(f"{Path(path).name}: two cameras are called {twice!r}; rename one.")
    return cameras


def _read_file(path: Path) -> list[Camera]:
    """Read one file, by what is in it."""
    text = read_text(path, expected=_EXPECTED, most_bytes=2**24, error=CalibrationError)
    if "!!opencv-matrix" in text:
        return _read_opencv(path, text)
    first = next((line.strip().lower() for line in text.split("\n") if line.strip()), "")
    if first == _HEAD[0]:
        return [_read_mayacam(path, text)]
    if "[" not in text:
        raise CalibrationError(
            f"{path.name}: no calibration that is read here; expected {_EXPECTED}."
        )
    return _read_toml(path, text)


def _read_toml(path: Path, text: str) -> list[Camera]:
    """Read cameras as aniposelib, Pose2Sim and caliscope write them: a section each."""
    document = parse_toml(text, where=path.name, error=CalibrationError)
    cameras = []
    for key, section in {**document, **_of_caliscope(document.get("cameras"))}.items():
        if not (isinstance(section, dict) and "matrix" in section):
            continue
        where = f"{path.name}: [{key}]"
        if section.get("fisheye") is True:
            raise CalibrationError(
                f"{where} is a fisheye lens, of another model than pawnb straightens; calibrate "
                "again with the standard lens."
            )
        name = section.get("name", key)
        cameras.append(
            _camera(
                str(name),
                section.get("matrix"),
                section.get("distortions", ()),
                section.get("rotation"),
                section.get("translation"),
                size=section.get("size"),
                where=where,
            )
        )
    if not cameras:
        raise CalibrationError(f"{path.name}: no section of a camera; expected {_EXPECTED}.")
    return cameras


def _of_caliscope(sections: Any) -> dict[str, Any]:
    """Return sections ``[cameras.N]`` by the names that caliscope gives films, ``cam_N``.

    Cameras that it has not placed yet are left out, as it does in files for Anipose.
    """
    if not isinstance(sections, dict):
        return {}
    return {
        f"cam_{key}": section
        for key, section in sections.items()
        if isinstance(section, dict) and {"rotation", "translation"} <= section.keys()
    }


def _read_opencv(path: Path, text: str) -> list[Camera]:
    """Read the matrices of a FileStorage, with those of ``extri`` beside ``intri``."""
    found = _matrices(text, path.name)
    for beside in _beside(path):
        more = read_text(beside, expected=_EXPECTED, most_bytes=2**24, error=CalibrationError)
        found = {**_matrices(more, beside.name), **found}
    if {"M1", "M2", "R", "T"} <= found.keys():  # the first camera is the origin
        pairs = {
            "1": (found["M1"], found.get("D1"), np.eye(3), np.zeros(3)),
            "2": (found["M2"], found.get("D2"), found["R"], found["T"]),
        }
        return [
            _camera(f"cam{k}", *parts[:1], _none(parts[1]), *parts[2:], size=None, where=path.name)
            for k, parts in pairs.items()
        ]
    parts = {(kind, name): values for (kind, name), values in map(_kind_of, found.items())}
    names = list(dict.fromkeys(name for kind, name in parts if kind == "matrix"))
    cameras = [
        _camera(
            name,
            parts["matrix", name],
            _none(parts.get(("distortion", name))),
            parts.get(("rotation", name)),
            parts.get(("translation", name)),
            size=None,
            where=f"{path.name}: camera {name!r}",
        )
        for name in names
    ]
    if not cameras:
        raise CalibrationError(
            f"{path.name}: none of the matrices {', '.join(found) or '(none)'} is named like that "
            f"of a camera ({', '.join(_INTRINSIC[:3])}); expected {_EXPECTED}."
        )
    return cameras


def _beside(path: Path) -> list[Path]:
    """Return ``extri`` beside ``intri`` or the other way round, where it is there."""
    return [
        beside
        for own, other in (("intri", "extri"), ("extri", "intri"))
        if own in path.name and (beside := path.with_name(path.name.replace(own, other))).is_file()
    ]


def _none(values: FloatArray | None) -> Any:
    """Return no coefficients where a camera has no distortion."""
    return () if values is None else values


def _matrices(text: str, where: str) -> dict[str, np.ndarray]:
    """Return the matrices of a FileStorage by name; in a section, ``section.name``."""
    sections = [(m.start(), m["name"]) for m in _SECTION.finditer(text)]
    found = {}
    for m in _MATRIX.finditer(text):
        shape = (int(m["rows"]), int(m["cols"]))
        try:
            numbers = [float(word) for word in m["data"].replace("\n", " ").split(",")]
            values = np.array(numbers).reshape(shape)
        except ValueError:
            raise CalibrationError(
                f"{where}: {m['name']} is not {shape[0]} x {shape[1]} numbers; copy the file again."
            ) from None
        inside = [name for at, name in sections if at < m.start()] if m["indent"] else []
        found[f"{inside[-1]}.{m['name']}" if inside else m["name"]] = values
    return found


def _kind_of(item: tuple[str, FloatArray]) -> tuple[tuple[str, str], FloatArray]:
    """Tell what a matrix is and of which camera, by its name."""
    name, values = item
    section, _, word = name.rpartition(".")
    for kind, words in (
        ("matrix", _INTRINSIC), ("distortion", _DISTORTION),
        ("rotation", _ROTATION), ("translation", _TRANSLATION),
    ):  # fmt: skip
        for known in words:
            if word == known and section:
                return (kind, section), values
            if not section and word.startswith(f"{known}_") and word not in words:
                if kind == "rotation" and known == "R" and values.size == 3:
                    return ("rotation", word[len(known) + 1 :]), values
                return (kind, word[len(known) + 1 :]), values
            if word == known and not section:
                return (kind, "cam1"), values
    return ("other", name), values


def _read_mayacam(path: Path, text: str) -> Camera:
    """Read MayaCam 2.0 of XMALab: four headings, each with its rows of numbers."""
    parts: dict[str, list[list[float]]] = {}
    rows: list[list[float]] = []
    for line in text.split("\n"):
        word = line.strip().lower()
        if word in _HEAD:
            rows = parts.setdefault(word, [])
        elif word:
            try:
                rows.append([float(cell) for cell in re.split(r"[,\s]+", word.strip(","))])
            except ValueError:
                raise CalibrationError(
                    f"{path.name}: {line.strip()[:40]!r} is no row of numbers; expected the "
                    f"headings {', '.join(_HEAD)} of MayaCam 2.0."
                ) from None
    missing = [word for word in _HEAD if not parts.get(word)]
    if missing:
        raise CalibrationError(f"{path.name}: no {missing[0]}; expected MayaCam 2.0 of XMALab.")
    size = [int(x) for x in np.ravel(parts["image size"][0])]
    return _camera(
        path.stem, parts["camera matrix"], (), parts["rotation"], parts["translation"],
        size=size, where=path.name,
    )  # fmt: skip


def _camera(
    name: str, matrix: Any, distortion: Any, rotation: Any, translation: Any, *,
    size: Any, where: str,
) -> Camera:  # fmt: skip
    """Check the parts of a camera and put them together."""
    K = _array(matrix, "matrix", where)
    if K.shape != (3, 3) or not (K[0, 0] > 0 and K[1, 1] > 0 and (K[2] == (0, 0, 1)).all()):
        raise CalibrationError(
            f"{where}: matrix is none of a camera; expected [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]."
        )
    if np.array_equal(K, np.eye(3)):
        raise CalibrationError(
            f"{where}: the camera is not calibrated yet (its matrix is 1, 0, 0 ...); calibrate it "
            "in the program that wrote the file."
        )
    D = _array(distortion, "distortion", where).ravel()
    if len(D) not in _COUNTS:
        raise CalibrationError(
            f"{where}: {len(D)} distortion coefficients; expected 4, 5, 8, 12 or 14."
        )
    R, t = _array(rotation, "rotation", where), _array(translation, "translation", where).ravel()
    if R.size == 3 and np.linalg.norm(R) > 2 * np.pi:
        raise CalibrationError(
            f"{where}: rotation is a vector {np.linalg.norm(R):.1f} long; expected an axis times "
            "an angle in radians, 6.28 at most (degrees?)."
        )
    if R.size == 3:
        R = Rotation.from_rotvec(R.ravel()).as_matrix()
    if R.shape != (3, 3) or not np.allclose(R @ R.T, np.eye(3), atol=1e-3):
        raise CalibrationError(f"{where}: rotation is none; expected a vector of 3, or a matrix.")
    if np.linalg.det(R) < 0:
        raise CalibrationError(
            f"{where}: rotation mirrors space (its determinant is -1): axes or pictures were "
            "flipped when it was made; expected right-handed axes, with x to the right, y down and "
            "z forwards in the camera."
        )
    if t.shape != (3,):
        raise CalibrationError(f"{where}: translation has {t.size} numbers; expected 3.")
    pair = (
        tuple(int(x) for x in size) if isinstance(size, list | tuple) and len(size) == 2 else None
    )
    return Camera(
        name=name,
        matrix=K,
        distortion=tuple(float(x) for x in D),
        rotation=R,
        translation=t,
        size=pair,  # type: ignore[arg-type]
    )


def _array(values: Any, what: str, where: str) -> FloatArray:
    """Return finite numbers as an array."""
    try:
        array = np.array(values, dtype=float)
    except (TypeError, ValueError):
        array = np.array(np.nan)
    if array.size > 100 or not np.isfinite(array).all():
        raise CalibrationError(f"{where}: {what} is missing or no numbers; calibrate again.")
    return array


@checked_arguments
def coefs_of_cameras(cameras: Sequence[Camera]) -> tuple[FloatArray, FloatArray]:
    """Return DLT coefficients of cameras, for their straightened pictures.

    Parameters
    ----------
    cameras : sequence of Camera
        The cameras.

    Returns
    -------
    coefs : ndarray, shape (11, n_cameras)
        Coefficients with L12 = 1.
    origin : ndarray, shape (3,)
        Where the origin of the coefficients lies in the space of the calibration: zero, but where
        a camera stands (or looks sideways) at zero, which has no such coefficients; then the
        point that all optical axes pass nearest to.

    Examples
    --------
    >>> coefs, origin = pawnb.io.coefs_of_cameras(cameras)
    >>> coefs.shape
    (11, 2)
    """
    centres = np.array([-c.rotation.T @ c.translation for c in cameras])
    depth = np.array([c.translation[2] for c in cameras])
    reach = max(
        float(np.abs(centres - centres.mean(axis=0)).max()), float(np.abs(depth).max()), 1e-12
    )
    origin = np.zeros(3)
    if (np.abs(depth) < _FAR * reach).any():
        # nearest to all lines of sight: sum over cameras of the projections across each axis
        across = [np.eye(3) - np.outer(c.rotation[2], c.rotation[2]) for c in cameras]
        total = np.sum([a @ x for a, x in zip(across, centres, strict=True)], axis=0)
        origin = np.linalg.lstsq(np.sum(across, axis=0), total, rcond=None)[0]
    columns = []
    for camera in cameras:
        t = camera.translation + camera.rotation @ origin
        P = camera.matrix @ np.column_stack([camera.rotation, t])
        if abs(P[2, 3]) < _FAR * reach:
            raise CalibrationError(
                f"camera {camera.name!r} has no DLT coefficients: it stands where the cameras look."
            )
        columns.append((P / P[2, 3]).ravel()[:11])
    return np.stack(columns, axis=1), origin
