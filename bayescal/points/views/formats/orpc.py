"""Corners of AprilTag boards, a file per image (``.orpc``), and the boards (``.dsc``, ``.tp``).

The format of the Deltille detector, as BabelCalib reads it (github.com/ylochman/babelcalib,
core/feature): five lines of "key: value" (filename, width, height, num_corners, encoding), then
board, point, flag, x, y, numbers from 0 and pixels with centres at integers. A .dsc lists, for each
board, a line "id, rows, columns, side", one with the family of its tags, and its points "tag, i, j,
x, y, z" in centimetres; a .tp beside it places boards: the id and three rows of [R t], millimetres.
"""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from bayescal.arrays import Array
from bayescal.errors import InputError
from bayescal.points.tables.content import read_file
from bayescal.points.tables.text import decode, quoted
from bayescal.points.views.formats.arrays import Seen, assembled
from bayescal.points.views.formats.source import Source
from bayescal.points.views.views import Views
from bayescal.rounding import counted

NAME = "ORPC corners"
HEADER = 5
MM = 10.0  # in a centimetre
UP = 4  # folders above the corners in which a board is looked for
MOST_IMAGES, LARGEST = 10_000, 10_000_000


@dataclass(frozen=True)
class Corner:
    """A corner found in an image: its line in the file, its board and number, and r, c."""

    line: int
    board: int
    point: int
    pixel: tuple[float, float]


def recognises(source: Source) -> bool:
    """Whether it is such a file, or a folder of them."""
    return source.suffix == ".orpc" or (source.is_folder and bool(_corner_files(source)))


def read(source: Source) -> Views:
    """Read a folder of corners, or one file.

    Raises
    ------
    InputError
        Where the boards are not found, or a line can't be used; the message names it.
    """
    if source.board is not None:
        raise InputError(f"{source.name}: its boards are in a .dsc; name that by --board")
    files = _corner_files(source) if source.is_folder else [Path(source.name)]
    if len(files) > MOST_IMAGES:
        raise InputError(f"{source.name}: holds {len(files)} images; {MOST_IMAGES} are read")
    described = source.target if source.target is not None else _description(source)
    target = read_target(described)
    digest = hashlib.sha256(b"".join(one.tobytes() for one in target.values()))
    seen: list[Seen] = []
    sizes: dict[tuple[float, float], Path] = {}
    placed = {board for board, _ in target}
    unplaced = 0
    for file in files:
        raw = source.raw if not source.is_folder else _read(file)
        digest.update(raw)
        size, corners = _image(str(file), decode(str(file), raw))
        mine = [corner for corner in corners if corner.board in placed]
        unplaced += len(corners) - len(mine)
        world = np.array([_place(str(file), one, target) for one in mine]).reshape(-1, 3)
        pixels = np.array([one.pixel for one in mine]).reshape(-1, 2)
        sizes.setdefault(size, file)
        seen.append(Seen(file.stem, world, pixels))
    if len(sizes) > 1:
        (one, a), (other, b) = list(sizes.items())[:2]
        raise InputError(
            f"{source.name}: {a.name} is of an image of {one[0]:g} by {one[1]:g} px, {b.name} of "
            f"{other[0]:g} by {other[1]:g}; give the views of one camera at a time"
        )
    notes = [f"boards as in {described.name}, mm"]
    if unplaced:
        notes.append(f"{counted(unplaced, 'point')} on boards that nothing places left out")
    return assembled(source, seen, next(iter(sizes)), tuple(notes), sha256=digest.hexdigest())


def _corner_files(source: Source) -> list[Path]:
    try:
        return sorted(Path(source.name).glob("*.orpc"))
    except OSError:
        return []


def _description(source: Source) -> Path:
    """Find the one .dsc in the folder of the corners, or in the nearest above that has one."""
    folder = Path(source.name).absolute()
    for place in [folder, *folder.parents][:UP]:
        found = sorted(place.glob("*.dsc")) if place.is_dir() else []
        if len(found) == 1:
            return found[0]
        if found:
            break
    raise InputError(f"{source.name}: whose corners? name the boards' file: --board FILE.dsc")


def read_target(path: Path) -> dict[tuple[int, int], Array]:
    """Points of all boards in one frame, x, y, z ``(3,)`` mm, by board and number.

    Raises
    ------
    InputError
        Where the files can't be used.
    """
    boards = _boards(path)
    placed = path.with_suffix(".tp")
    poses = _poses(placed) if placed.is_file() else {}
    if len(boards) == 1:
        poses = {next(iter(boards)): np.eye(3, 4), **poses}
    if not set(boards) & set(poses):
        raise InputError(f"{path}: nothing places its boards; {placed.name} must, beside it")
    target = {}
    for board, points in boards.items():
        if board in poses:
            pose = poses[board]
            for number, point in enumerate(points):
                target[board, number] = pose[:, :3] @ point + pose[:, 3]
    return target


def _boards(path: Path) -> dict[int, list[Array]]:
    boards: dict[int, list[Array]] = {}
    latest: list[Array] | None = None
    for number, line in enumerate(decode(str(path), _read(path)).splitlines(), 1):
        fields = [field.strip() for field in line.split(",")]
        where = f"{path}:{number}"
        if len(fields) == 4:
            (name,) = _numbers(where, fields[:1])
            if name in boards:
                raise InputError(f"{where}: board {name:g} stands twice")
            latest = boards[int(name)] = []
        elif len(fields) == 6 and latest is not None:
            latest.append(np.array(_numbers(where, fields[3:])) * MM)
        elif len(fields) != 2 and line.strip():
            raise InputError(f"{where}: {quoted(line)} is neither a board nor a point of one")
    if not any(boards.values()):
        raise InputError(f"{path}: describes no board")
    return boards


def _poses(path: Path) -> dict[int, Array]:
    """Poses [R t] of the boards, ``(3, 4)``, mm."""
    lines = decode(str(path), _read(path)).splitlines()
    words = [w for line in lines if not line.startswith("#") for w in line.split()]
    values = _numbers(str(path), words)
    if len(values) % 13:
        raise InputError(f"{path}: must have 13 numbers for each board, its number and [R t]")
    rows = np.array(values).reshape(-1, 13)
    for row in rows:
        turn = row[1:].reshape(3, 4)[:, :3]
        if not np.allclose(turn @ turn.T, np.eye(3), atol=1e-3) or np.linalg.det(turn) < 0:
            raise InputError(f"{path}: board {row[0]:g} is placed by no rotation")
    return {int(row[0]): row[1:].reshape(3, 4) for row in rows}


def _image(name: str, text: str) -> tuple[tuple[float, float], list[Corner]]:
    """Size of an image, px, and the corners found in it."""
    lines = text.splitlines()
    header = dict(line.partition(":")[::2] for line in lines[:HEADER])
    try:
        width, height = (float(header[key]) for key in ("width", "height"))
        count = int(header["num_corners"])
    except (KeyError, ValueError):
        raise InputError(f"{name}: does not begin with width, height and num_corners") from None
    corners = []
    for number, line in enumerate(lines[HEADER:], HEADER + 1):
        if not line.strip():
            continue
        fields = line.split(",")
        if len(fields) != 5:
            raise InputError(
                f"{name}:{number}: has {len(fields)} fields; a corner is: board,point,1,x,y"
            )
        board, point, _, r, c = _numbers(f"{name}:{number}", fields)
        corners.append(Corner(number, int(board), int(point), (r, c)))
    if len(corners) != count:
        raise InputError(f"{name}: says {count} corners and has {len(corners)}; it was cut off")
    return (width, height), corners


def _place(name: str, corner: Corner, target: dict[tuple[int, int], Array]) -> Array:
    place = target.get((corner.board, corner.point))
    if place is None:
        raise InputError(
            f"{name}:{corner.line}: board {corner.board} has no point {corner.point}; is this the "
            "board that was seen?"
        )
    return place


def _numbers(where: str, fields: list[str]) -> list[float]:
    try:
        values = [float(field) for field in fields]
    except ValueError:
        raise InputError(f"{where}: {quoted(','.join(fields))} where numbers should be") from None
    if not all(math.isfinite(value) and abs(value) < 1e15 for value in values):
        raise InputError(f"{where}: {quoted(','.join(fields))} are no finite numbers")
    return values


def _read(path: Path) -> bytes:
    return read_file(path, "a file of corners or boards", LARGEST).raw
