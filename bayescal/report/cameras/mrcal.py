"""mrcal's ``.cameramodel``: lensmodel, intrinsics, pose (none), imagersize.

Its LENSMODEL_PINHOLE and LENSMODEL_OPENCV4, 5, 8 and 12 are OpenCV's (mrcal.secretsauce.net,
lensmodels); 'extrinsics' is what mrcal before 2.5 calls 'rt_cam_ref'.
"""

from __future__ import annotations

from bayescal.cameras.lenses import Lens
from bayescal.report.cameras.camera import FittedCamera, filled, shortest

NAME = "mrcal"
COVARIANCE = False
NO_POSE = "[ 0, 0, 0, 0, 0, 0 ]"


def holds(lens: Lens) -> bool:
    """Whether mrcal has the lens: up to opencv12."""
    return shortest(lens) is not None


def text(camera: FittedCamera) -> str:
    """Write the file."""
    length = shortest(camera.lens)
    assert length is not None, "asked of a lens that it holds"
    k = filled(camera, length) if camera.lens.names else []
    name = f"LENSMODEL_OPENCV{length}" if camera.lens.names else "LENSMODEL_PINHOLE"
    numbers = ", ".join(repr(float(v)) for v in [*camera.intrinsics.tolist(), *k])
    lines = [
        f"# {camera.about()}",
        "{",
        f"    'lensmodel':  '{name}',",
        "    # intrinsics are fx,fy,cx,cy,distortion0,distortion1,....",
        f"    'intrinsics': [ {numbers} ],",
        f"    'rt_cam_ref': {NO_POSE},",
        f"    'extrinsics': {NO_POSE},",
        f"    'imagersize': [ {camera.size[0]}, {camera.size[1]} ]",
        "}",
    ]
    return "\n".join(lines) + "\n"
