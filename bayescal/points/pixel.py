"""What stands for a pixel: bounds of noise and of distortion are told in it.

Where readings are no pixels, or the image size is unknown so that nobody can tell, a fraction of
their span stands for one: bounds in absolute pixels would lie above the noise of readings that
were divided by the image's width.
"""

from __future__ import annotations

# An image of about this many pixels is taken where readings have no size of their own.
TYPICAL_SIZE = 1920.0
# Smallest scale of noise and of distortion, px: below what any detector tells apart.
FLOOR = 0.01
# A stated image smaller than this, px, is one whose readings are shares of it.
SMALLEST_IMAGE = 10.0


def pixel_of(size: float, *, known: bool) -> float:
    """Give what stands for a pixel, in units of the readings.

    Parameters
    ----------
    size : float
        Image size along an axis, or the span of the readings that stands for it.
    known : bool
        Whether it is an image size.
    """
    return 1.0 if known and size >= SMALLEST_IMAGE else size / TYPICAL_SIZE
