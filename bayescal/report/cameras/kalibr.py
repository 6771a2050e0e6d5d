"""Kalibr's camchain, YAML (github.com/ethz-asl/kalibr/wiki: yaml-formats, supported-models).

Projection and distortion are stated apart: pinhole with radtan (k1, k2, p1, p2), with equidistant
(a fisheye's four) or none; eucm [alpha beta ...] and ds [xi alpha ...], the double sphere.
"""

from __future__ import annotations

from collections.abc import Sequence

from bayescal.cameras.lenses import Lens
from bayescal.report.cameras.camera import FittedCamera, filled, fisheye, is_fisheye, shortest

NAME = "Kalibr camchain"
COVARIANCE = False
# Lenses whose shape is a part of the projection, by its name there.
PROJECTIONS = {"eucm": "eucm", "double-sphere": "ds"}


def holds(lens: Lens) -> bool:
    """Whether Kalibr has the lens: opencv4, a fisheye of four, eucm, double-sphere."""
    return lens.name in PROJECTIONS or is_fisheye(lens) or shortest(lens) == 4


def text(camera: FittedCamera) -> str:
    """Write the file."""
    lens, shape = camera.lens, camera.coefficients.tolist()
    projection, before, distortion, k = "pinhole", [], "none", []
    if lens.name in PROJECTIONS:
        projection, before = PROJECTIONS[lens.name], shape
    elif is_fisheye(lens):
        distortion, k = "equidistant", fisheye(camera)
    elif lens.names:
        distortion, k = "radtan", filled(camera, 4)
    lines = [
        f"# {camera.about()}",
        "cam0:",
        "  cam_overlaps: []",
        f"  camera_model: {projection}",
        f"  distortion_coeffs: {_list(k)}",
        f"  distortion_model: {distortion}",
        f"  intrinsics: {_list([*before, *camera.intrinsics.tolist()])}",
        f"  resolution: [{camera.size[0]}, {camera.size[1]}]",
        "  rostopic: /cam0/image_raw",
    ]
    return "\n".join(lines) + "\n"


def _list(values: Sequence[float]) -> str:
    return "[" + ", ".join(repr(float(v)) for v in values) + "]"
