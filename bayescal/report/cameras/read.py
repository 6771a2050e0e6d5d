"""Reads a camera that OpenCV, ROS or `save_camera` wrote as YAML.

The files are a handful of keys, each with a number or a matrix; OpenCV's and ROS's differ in their
heading and in how they name the model.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from bayescal.arrays import Array
from bayescal.cameras.lenses import Lens, lens_named
from bayescal.errors import InputError
from bayescal.points.tables.content import LARGEST_SETUP, read_file
from bayescal.report.cameras.camera import FittedCamera

# Names of lenses by the number of OpenCV's coefficients that a file gives.
PLANAR = {4: "opencv4", 5: "opencv5", 8: "opencv8", 12: "opencv12"}
ROS = ("plumb_bob", "rational_polynomial", "equidistant")


def load_camera(path: str | Path) -> FittedCamera:
    """Read a camera: OpenCV's YAML or ROS's camera_info.

    Parameters
    ----------
    path : str or Path

    Returns
    -------
    FittedCamera
        Without a covariance.

    Raises
    ------
    InputError
        Where the file can't be read, lacks something, or its lens is not known here.
    """
    text = read_file(path, "a camera", LARGEST_SETUP).text()
    matrix = _matrix(text, "camera_matrix", path)
    if matrix is None or matrix.size != 9:
        raise InputError(
            f"{path}: holds no camera_matrix of nine numbers; a camera of OpenCV or ROS (YAML) has "
            "one, as bayescal calibrate --camera opencv FILE.yml writes it"
        )
    fx, skew, cx, _, fy, cy = matrix.ravel().tolist()[:6]
    if skew:
        raise InputError(f"{path}: its pixels are skewed by {skew:g}, which no lens here is")
    size = tuple(_whole(text, name, path) for name in ("image_width", "image_height"))
    values = _matrix(text, "distortion_coefficients", path)
    k = np.zeros(0) if values is None else values.ravel()
    lens, k = _lens(text, k, path)
    try:
        return FittedCamera.from_arrays(lens, [fx, fy, cx, cy], k, (size[0], size[1]))
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def _lens(text: str, k: Array, path: str | Path) -> tuple[Lens, Array]:
    """Choose the lens that a file means, and give its coefficients."""
    model = _word(text, "distortion_model")
    if model not in (None, *ROS):
        raise InputError(f"{path}: distortion_model {model} is none of {', '.join(ROS)}")
    if model == "equidistant" or _word(text, "fisheye_model") == "1":
        if len(k) != 4:
            raise InputError(f"{path}: a fisheye has 4 distortion coefficients, not {len(k)}")
        return lens_named("fisheye", order=4), k
    if not len(k) or (len(k) in PLANAR and not k.any()):
        return lens_named("radial", order=0, tangential=False), np.zeros(0)
    if len(k) == 14 and not k[12:].any():
        k = k[:12]
    if len(k) not in PLANAR:
        tilted = " with a tilted sensor" if len(k) == 14 else ""
        raise InputError(
            f"{path}: {len(k)} distortion coefficients{tilted} are no lens known here; OpenCV's "
            "with 4, 5, 8 or 12 are"
        )
    return lens_named(PLANAR[len(k)]), k


def _matrix(text: str, name: str, path: str | Path) -> Array | None:
    """Numbers under a key, ``(n,)``; None where it is missing."""
    found = re.search(rf"^{name}:[^\[]*?\bdata:\s*\[([^\]]*)\]", text, re.MULTILINE)
    if found is None:
        return None
    try:
        return np.array([float(part) for part in found[1].replace(",", " ").split()])
    except ValueError:
        raise InputError(f"{path}: {name} holds something that is no number") from None


def _word(text: str, name: str) -> str | None:
    found = re.search(rf"^{name}:[ \t]*(\S+)", text, re.MULTILINE)
    return None if found is None else found[1].strip("\"'")


def _whole(text: str, name: str, path: str | Path) -> int:
    word = _word(text, name)
    if word is None or not re.fullmatch(r"[1-9]\d{0,6}", word):
        raise InputError(f"{path}: holds no {name}; add it (px), as OpenCV's calibration writes it")
    return int(word)
