"""COLMAP's ``cameras.txt``: one camera, its model, image size and parameters.

COLMAP's pixel centres are at 0.5, so that its principal point is ours plus a half
(colmap.github.io, cameras). Its models are those of src/colmap/sensor/models.h.
"""

from __future__ import annotations

from bayescal.cameras.lenses import Lens
from bayescal.report.cameras.camera import FittedCamera, filled, fisheye, is_fisheye, shortest

NAME = "COLMAP"
COVARIANCE = False
CENTRE = 0.5
# Lenses of the same name and coefficients there.
ALIKE = ("division", "eucm")


def holds(lens: Lens) -> bool:
    """Whether COLMAP has the lens: up to opencv8, a fisheye of four, division, eucm."""
    if lens.name in ALIKE or is_fisheye(lens):
        return True
    return (shortest(lens) or 99) <= 8


def text(camera: FittedCamera) -> str:
    """Write the file."""
    lens = camera.lens
    if lens.name in ALIKE:
        model, k = lens.name.upper(), camera.coefficients.tolist()
    elif is_fisheye(lens):
        model, k = "OPENCV_FISHEYE", fisheye(camera)
    elif not lens.names:
        model, k = "PINHOLE", []
    elif shortest(lens) == 4:
        model, k = "OPENCV", filled(camera, 4)
    else:
        model, k = "FULL_OPENCV", filled(camera, 8)
    fx, fy, cx, cy = camera.intrinsics.tolist()
    parameters = [fx, fy, cx + CENTRE, cy + CENTRE, *k]
    numbers = " ".join(repr(float(v)) for v in parameters)
    lines = [
        "# Camera list with one line of data per camera:",
        "#   CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]",
        f"# {camera.about()}; pixel centres at 0.5",
        f"1 {model} {camera.size[0]} {camera.size[1]} {numbers}",
    ]
    return "\n".join(lines) + "\n"
