"""The camera of a run: one small file beside the draws, so that it answers at once."""

from __future__ import annotations

from typing import Any

from bayescal.errors import InputError

CAMERA, MANIFEST = "camera.npz", "run.json"


def camera_bytes_of(result: Any) -> bytes | None:
    """Encode the camera of a result; None where it has none."""
    from bayescal.prediction.calibrated.saved import camera_bytes
    from bayescal.prediction.calibrated.sources import camera_of

    try:
        return camera_bytes(camera_of(result))
    except InputError:
        return None
