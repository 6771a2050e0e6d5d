"""One image of a COLMAP text model: images.txt, with points3D.txt and cameras.txt beside it.

The world points are turned into the camera's frame by the image's pose (x right, y down, z
forward), so that the camera stands at the origin; COLMAP's pixel centres at 0.5 become integers.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from bayescal.arrays import Array
from bayescal.errors import InputError
from bayescal.points.exports.found import Found
from bayescal.points.setup import Setup
from bayescal.points.tables.content import Content, read_file
from bayescal.points.tables.sniffing import Line, TextTable
from bayescal.points.tables.text import quoted

NAME = "COLMAP text model"


def recognises(content: Content) -> bool:
    """Whether it begins as COLMAP's list of images."""
    return content.raw.lstrip().startswith(b"# Image list with two lines of data per image")


def read(content: Content, view: str | None) -> Found:
    """Read the points of one image, and the image's size.

    Raises
    ------
    InputError
        Where the files beside it can't be read, or no view is chosen of several.
    """
    name = content.name
    if content.path is None:
        raise InputError(f"{name}: is a {NAME}; name its images.txt, beside points3D.txt")
    images = _images(content)
    if view is None and len(images) > 1:
        names = quoted(", ".join(images))
        raise InputError(f"{name}: holds {len(images)} views, {names}; choose one with --view")
    if view is not None and view not in images:
        raise InputError(f"{name}: holds no view {quoted(view)}, but {quoted(', '.join(images))}")
    line, head, seen = images[next(iter(images)) if view is None else view]
    world = _points(content.path.with_name("points3D.txt"))
    try:
        pose = np.array(head[1:8], dtype=float)
        x, y, ids = seen[0::3], seen[1::3], seen[2::3]
        known = [(k, i) for k, i in enumerate(ids) if i in world]
        pixels = np.array([[float(x[k]) - 0.5, float(y[k]) - 0.5] for k, _ in known])
        inside = [world[i] @ _rotation(pose[:4]).T + pose[4:] for _, i in known]
    except (ValueError, IndexError):
        raise InputError(f"{name}:{line}: is no image of a {NAME}; export it anew") from None
    lines = tuple(
        Line(line + 1, (*(repr(float(v)) for v in (*point, *pixel)), i, head[9]))
        for point, pixel, (_, i) in zip(inside, pixels, known, strict=True)
    )
    table = TextTable(name, ("x", "y", "z", "r", "c", "label", "view"), lines, line)
    note = (
        f"{name} is a {NAME}: its points are in the frame of the camera of {head[9]}, and were "
        "estimated from pixels under COLMAP's own lens"
    )
    return Found(table, _size(content.path.with_name("cameras.txt"), head[8]), (note,))


def _images(content: Content) -> dict[str, tuple[int, list[str], list[str]]]:
    """By name, each image's line, its fields, and those of its points in the line below."""
    lines = content.text().split("\n")
    found, number = {}, 0
    while number < len(lines):
        head = lines[number].split(maxsplit=9)
        if len(head) == 10 and not head[0].startswith("#"):
            seen = lines[number + 1].split() if number + 1 < len(lines) else []
            found[head[9].strip()] = (number + 1, head, seen)
            number += 1
        number += 1
    if not found:
        raise InputError(f"{content.name}: is a {NAME} without images")
    return found


def _points(path: Path) -> dict[str, Array]:
    """World points by their number."""
    found = {}
    for number, fields in _rows(path):
        try:
            found[fields[0]] = np.array(fields[1:4], dtype=float).reshape(3)
        except ValueError:
            raise InputError(f"{path}:{number}: is no point of a {NAME}; export it anew") from None
    return found


def _size(path: Path, camera: str) -> Setup | None:
    """Image size by the camera's line; None without one."""
    if not path.is_file():
        return None
    for number, fields in _rows(path):
        if fields[0] == camera:
            try:
                return Setup(width=float(fields[2]), height=float(fields[3]))
            except (ValueError, IndexError):
                raise InputError(f"{path}:{number}: is no camera of a {NAME}") from None
    return None


def _rows(path: Path) -> Iterator[tuple[int, list[str]]]:
    text = read_file(path, f"the files of a {NAME} together").text()
    for number, line in enumerate(text.split("\n"), 1):
        if line.strip() and not line.lstrip().startswith("#"):
            yield number, line.split()


def _rotation(q: Array) -> Array:
    """Rotation matrix of a quaternion w, x, y, z."""
    from scipy.spatial.transform import Rotation

    matrix: Array = Rotation.from_quat(np.roll(q, -1)).as_matrix()
    return matrix
