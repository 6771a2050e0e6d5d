"""A sheet of small pictures: what was found in each photograph, and where nothing was."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bayescal.detection.detect import THUMBNAIL, Photograph
from bayescal.detection.opencv import opencv

MOST = 400  # pictures on a sheet
MARGIN, TITLE = 8, 20  # px
INK, RED, WHITE = (40, 40, 40), (40, 40, 200), (255, 255, 255)  # blue, green, red


def contact_sheet(photographs: Sequence[Photograph]) -> bytes:
    """Draw the sheet, PNG: points joined in their order, from blue to red."""
    shown = photographs[:MOST]
    columns = min(max(math.ceil(math.sqrt(len(shown))), 1), 10)
    width, height = THUMBNAIL + MARGIN, _tallest(shown) + TITLE + MARGIN
    rows = math.ceil(len(shown) / columns)
    sheet = np.full((rows * height + MARGIN, columns * width + MARGIN, 3), 255, dtype=np.uint8)
    for i, one in enumerate(shown):
        row, column = divmod(i, columns)
        top, left = MARGIN + row * height, MARGIN + column * width
        _draw(sheet[top : top + height - MARGIN, left : left + THUMBNAIL], one)
    done, raw = opencv().imencode(".png", sheet)
    assert done, "PNG is always had"
    return bytes(raw)


def _tallest(shown: Sequence[Photograph]) -> int:
    return max([one.thumbnail.shape[0] for one in shown if one.thumbnail is not None], default=40)


def _draw(place: NDArray[np.uint8], one: Photograph) -> None:
    """Draw one photograph into its place on the sheet."""
    cv2 = opencv()
    if one.sighting is not None:
        _write(cv2, place, f"{one.name[-32:]}: {len(one.sighting.points)}", INK)
    else:
        _write(cv2, place, f"{one.name[-16:]}: {one.why}"[:48], RED)
    if one.thumbnail is None or one.size is None:
        return
    small = cv2.cvtColor(one.thumbnail, cv2.COLOR_GRAY2BGR)
    if one.sighting is not None:
        # A thumbnail's pixel k covers the image from k / scale - 0.5 on.
        scale = small.shape[1] / one.size[0]
        at = np.rint(((one.sighting.pixels + 0.5) * scale - 0.5) * 8).astype(np.int32)
        _points(cv2, small, at)
    place[TITLE : TITLE + small.shape[0], : small.shape[1]] = small


def _points(cv2: Any, small: NDArray[np.uint8], at: NDArray[np.int32]) -> None:
    """Join points, in eighths of a pixel, and ring them; the first has a larger ring."""
    steps = np.linspace(0, 255, len(at)).astype(np.uint8)
    colours = cv2.applyColorMap(steps[:, None], cv2.COLORMAP_TURBO)[:, 0].tolist()
    for k in range(1, len(at)):
        ends = tuple(at[k - 1].tolist()), tuple(at[k].tolist())
        cv2.line(small, *ends, colours[k], 1, cv2.LINE_AA, 3)
    for k, (point, colour) in enumerate(zip(at.tolist(), colours, strict=True)):
        cv2.circle(small, tuple(point), 48 if k == 0 else 20, colour, 1, cv2.LINE_AA, 3)


def _write(cv2: Any, place: NDArray[np.uint8], words: str, ink: tuple[int, int, int]) -> None:
    """Write a picture's title."""
    plain = words.encode("ascii", "replace").decode()  # all that OpenCV's letters have
    cv2.putText(place, plain, (2, 14), cv2.FONT_HERSHEY_SIMPLEX, 0.42, ink, 1, cv2.LINE_AA)
