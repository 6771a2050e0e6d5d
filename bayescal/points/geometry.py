"""Geometry that nobody would mean: what it looks like, the likely mistake, and what mends it."""

from __future__ import annotations

import math

import numpy as np

from bayescal.arrays import Array
from bayescal.points.correspondences import Correspondences
from bayescal.points.setup import AXES
from bayescal.rounding import counted, significant

# Degrees off the camera's axis beyond which no lens of this kind sees a point.
FAR_OFF_AXIS = 80.0
# Degrees that all points together span below which the setup is doubtful.
NARROW = 0.5
# A pixel that follows its coordinate, or runs against it, correlates as strongly as this.
FOLLOWS = 0.9
SHOWN = 3


def odd_geometry(points: Correspondences) -> list[str]:
    """Say what of points and camera nobody would mean, one sentence each.

    Returns
    -------
    list of str
        The likely mistake, and the option that mends it.
    """
    camera = points.camera_frame()
    depth = camera[:, 2]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        slopes = camera[:, :2] / depth[:, None]
    if not np.isfinite(slopes).all():
        return []  # refused elsewhere, with the point named
    off = _off_axis(points, slopes) or _narrow(camera)
    return [*_behind(points, depth), *off, *_turned(points, slopes)]


def _behind(points: Correspondences, depth: Array) -> list[str]:
    """Points behind a camera that looks along z, unless it looks the other way on all of them."""
    behind = np.flatnonzero(depth < 0)
    if not behind.size:
        return []
    if behind.size == len(depth):
        return [
            "every point lies behind the camera (z < 0): z counts the other way, or the camera's "
            "z is wrong; correct the sign of z or state --camera-position X Y Z"
        ]
    places = [points.place(int(i)) for i in behind[:SHOWN]]
    rest = f" and {behind.size - SHOWN} more" if behind.size > SHOWN else ""
    one = behind.size == 1
    return [
        f"{counted(int(behind.size), 'point')} of {len(depth)} {'lies' if one else 'lie'} behind "
        f"the camera (z < 0), where it sees nothing: {', '.join(places)}{rest}; correct the world "
        f"coordinates of {'this row' if one else 'these rows'}, or --camera-position"
    ]


def _off_axis(points: Correspondences, slopes: Array) -> list[str]:
    """All points far to one side, as when coordinates of a national grid have no camera in them."""
    angles = np.degrees(np.arctan(np.hypot(*slopes.T)))
    if angles.min() < FAR_OFF_AXIS:
        return []
    lows, highs = slopes.min(axis=0).tolist(), slopes.max(axis=0).tolist()
    spans = " and ".join(
        f"{name} from {low:.5g} to {high:.5g}"
        for name, low, high in zip(("x/z", "y/z"), lows, highs, strict=True)
    )
    stated = (
        "the camera's position is not stated"
        if not any(points.setup.position)
        else ("the camera's position is wrong, or it does not look along z")
    )
    return [
        f"every point lies {angles.min():.0f} degrees or more off the camera's axis ({spans}): "
        f"probably {stated}; give --camera-position X Y Z in the world's own coordinates"
    ]


def _narrow(camera: Array) -> list[str]:
    """All points within half a degree of view."""
    camera = camera / np.abs(camera).max()  # lengths of any unit have a square
    rays = camera / np.linalg.norm(camera, axis=1, keepdims=True)
    middle = rays.mean(axis=0)
    middle /= np.linalg.norm(middle)
    across = np.linalg.norm(np.cross(rays, middle), axis=1).max()
    view = 2 * math.degrees(math.asin(min(1.0, float(across))))
    if view >= NARROW:
        return []
    return [
        f"all points lie within {significant(view)} degrees of view: z is probably in another unit "
        "than x and y, or --camera-position lies far from where the camera was"
    ]


def _turned(points: Correspondences, slopes: Array) -> list[str]:
    """One pixel coordinate runs against its world coordinate while the other follows."""
    along = [_correlation(slopes[:, i], points.pixel(axis)) for i, axis in enumerate(AXES)]
    if along[0] > FOLLOWS and along[1] < -FOLLOWS:
        mend = (
            "state c_from_bottom = false" if points.setup.c_from_bottom else "give --c-from-bottom"
        )
        return [
            "c falls where y/z rises, while r follows x/z: c is turned over, or y counts "
            f"downwards; {mend}, or turn the sign of y"
        ]
    if along[0] < -FOLLOWS and along[1] > FOLLOWS:
        return [
            "r falls where x/z rises, while c follows y/z: the world is mirrored; turn the sign "
            "of x, or of y and c together"
        ]
    return []


def _correlation(x: Array, t: Array) -> float:
    """Correlation of a regressor and its pixel; 0 where either is constant."""
    dx, dt = x - x.mean(), t - t.mean()
    size = math.sqrt(float(dx @ dx) * float(dt @ dt))
    return float(dx @ dt) / size if size else 0.0
