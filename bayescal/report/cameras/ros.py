"""ROS's camera_info as camera_calibration_parsers reads it, YAML.

Its distortion models (sensor_msgs/distortion_models.hpp) are plumb_bob, OpenCV's five;
rational_polynomial, its eight; equidistant, a fisheye's four.
"""

from __future__ import annotations

from collections.abc import Sequence

from bayescal.cameras.lenses import Lens
from bayescal.report.cameras.camera import FittedCamera, filled, fisheye, is_fisheye, shortest

NAME = "ROS camera_info"
COVARIANCE = False


def holds(lens: Lens) -> bool:
    """Whether ROS has the lens: up to opencv8, or a fisheye of four."""
    return is_fisheye(lens) or (shortest(lens) or 99) <= 8


def text(camera: FittedCamera) -> str:
    """Write the file."""
    length = shortest(camera.lens)
    if length is None:
        model, k = "equidistant", fisheye(camera)
    elif length <= 5:
        model, k = "plumb_bob", filled(camera, 5)
    else:
        model, k = "rational_polynomial", filled(camera, 8)
    fx, fy, cx, cy = camera.intrinsics.tolist()
    lines = [
        f"# {camera.about()}",
        f"image_width: {camera.size[0]}",
        f"image_height: {camera.size[1]}",
        "camera_name: camera",
        *_matrix("camera_matrix", 3, 3, camera.matrix.ravel().tolist()),
        f"distortion_model: {model}",
        *_matrix("distortion_coefficients", 1, len(k), k),
        *_matrix("rectification_matrix", 3, 3, [1.0, 0, 0, 0, 1.0, 0, 0, 0, 1.0]),
        *_matrix("projection_matrix", 3, 4, [fx, 0, cx, 0, 0, fy, cy, 0, 0, 0, 1.0, 0]),
    ]
    return "\n".join(lines) + "\n"


def _matrix(name: str, rows: int, columns: int, values: Sequence[float]) -> list[str]:
    numbers = ", ".join(repr(float(v)) for v in values)
    return [f"{name}:", f"  rows: {rows}", f"  cols: {columns}", f"  data: [{numbers}]"]
