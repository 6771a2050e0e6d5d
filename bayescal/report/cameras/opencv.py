"""OpenCV's YAML, with the keys of its calibration sample: camera_matrix, distortion_coefficients.

A fisheye has fisheye_model: 1 and goes to ``cv2.fisheye``; all others to ``cv2.projectPoints``.
"""

from __future__ import annotations

import numpy as np

from bayescal.cameras.lenses import Lens
from bayescal.report.cameras.camera import FittedCamera, filled, fisheye, is_fisheye, shortest
from bayescal.report.cameras.opencv_storage import HEADER, list_lines, matrix_lines

NAME = "OpenCV"
COVARIANCE = True


def holds(lens: Lens) -> bool:
    """Whether OpenCV has the lens: up to opencv12, or a fisheye of four."""
    return is_fisheye(lens) or shortest(lens) is not None


def text(camera: FittedCamera) -> str:
    """Write the file."""
    length = shortest(camera.lens)
    k = fisheye(camera) if length is None else filled(camera, max(length, 5))
    lines = [
        *HEADER,
        f"image_width: {camera.size[0]}",
        f"image_height: {camera.size[1]}",
        f"fisheye_model: {int(length is None)}",
        f'model: "{camera.about()}"',
        f"sound: {int(camera.sound)}",
        *matrix_lines("camera_matrix", camera.matrix),
        *matrix_lines("distortion_coefficients", np.array([k]).T),
    ]
    if camera.covariance is not None:
        sds = np.sqrt(np.diag(camera.covariance))[:, None]
        lines += matrix_lines("standard_deviations", sds)
        lines += matrix_lines("covariance", camera.covariance)
        lines += list_lines("parameters", camera.names)
    return "\n".join(lines) + "\n"
