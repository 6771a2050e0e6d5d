"""OpenCV, which only this room needs: had when asked for, and missed in one line."""

from __future__ import annotations

import io
import warnings
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import ExifTags, Image

from bayescal.arrays import Array
from bayescal.errors import InputError

GreyImage = NDArray[np.uint8]


def opencv() -> Any:
    """Import OpenCV.

    Raises
    ------
    InputError
        Where it is not installed.
    """
    try:
        import cv2
    except ImportError as error:
        found = "" if isinstance(error, ModuleNotFoundError) else f" ({error})"
        raise InputError(
            f"photographs are read by OpenCV, which can't be imported{found}; install it by: "
            "pip install 'bayescal[images]'"
        ) from None
    module: ModuleType = cv2
    return module


def decoded(raw: bytes) -> GreyImage | None:
    """Decode an image as the sensor has it (no turning by EXIF), grey; None where it is none."""
    cv2 = opencv()
    flags = cv2.IMREAD_GRAYSCALE | cv2.IMREAD_IGNORE_ORIENTATION
    try:
        image: GreyImage | None = cv2.imdecode(np.frombuffer(raw, np.uint8), flags)
    except cv2.error:  # more pixels than OpenCV takes, or no bytes at all
        return None
    return image


def is_turned(raw: bytes) -> bool:
    """Whether an image's file asks for it to be shown turned or mirrored."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of large images: this reads only the file's head
            orientation = Image.open(io.BytesIO(raw)).getexif().get(ExifTags.Base.Orientation, 1)
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError):
        return False
    return orientation in range(2, 9)


def pixels_of(corners: Any) -> Array:
    """Corners as OpenCV gives them, (n, 1, 2) or since 5 (n, 2), as ``(n, 2)``, px."""
    return np.asarray(corners, dtype=np.float64).reshape(-1, 2)
