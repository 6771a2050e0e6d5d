"""Photographs in colour: read, sampled elsewhere, and encoded again, by OpenCV."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bayescal.detection.detect import LARGEST
from bayescal.detection.opencv import opencv
from bayescal.points.tables.text import reason

Image = NDArray[Any]


def read_image(path: Path) -> tuple[Image | None, str]:
    """Read an image as the sensor has it, with its depth and channels; or say why not."""
    cv2 = opencv()
    try:
        if path.stat().st_size > LARGEST:
            return None, "the file is too large"
        raw = path.read_bytes()
    except OSError as error:
        return None, reason(error)
    try:
        image: Image | None = cv2.imdecode(np.frombuffer(raw, np.uint8), cv2.IMREAD_UNCHANGED)
    except cv2.error:  # more pixels than OpenCV takes, or no bytes at all
        image = None
    return image, "" if image is not None else "is no image that OpenCV reads"


def remapped(image: Image, r: NDArray[np.float32], c: NDArray[np.float32]) -> Image:
    """Sample an image at places r, c between its pixels, linearly; black outside."""
    cv2 = opencv()
    out: Image = cv2.remap(image, r, c, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT)
    return out


def encoded(image: Image, suffix: str) -> bytes | None:
    """Encode an image by its file's suffix, JPEG with as little loss as there is; or None."""
    cv2 = opencv()
    quality = [cv2.IMWRITE_JPEG_QUALITY, 100] if suffix.lower() in (".jpg", ".jpeg") else []
    try:
        done, raw = cv2.imencode(suffix, image, quality)
    except cv2.error:
        return None
    return bytes(raw) if done else None
