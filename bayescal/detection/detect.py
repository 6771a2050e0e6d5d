"""Views of a target from photographs."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from bayescal.detection.opencv import GreyImage, decoded, is_turned, opencv
from bayescal.detection.pattern import Pattern, Sighting
from bayescal.errors import InputError
from bayescal.points.paths import named_paths, short_names
from bayescal.points.tables.text import reason
from bayescal.points.views.views import Views
from bayescal.rounding import counted

LARGEST = 1 << 29  # bytes of an image's file
THUMBNAIL = 320  # px, the longer side
DECIMALS = 4  # of a pixel: a thousandth of what any detector can tell


@dataclass(frozen=True, eq=False)
class Photograph:
    """What became of one photograph.

    Attributes
    ----------
    name : str
        Of its view.
    size : tuple of int or None
        Width and height, px; None where it can't be read.
    sighting : Sighting or None
        What was found.
    why : str
        Why it makes no view; empty where it does.
    thumbnail : GreyImage or None
        A small picture of it.
    turned : bool
        Whether its file asks for it to be shown turned (EXIF); it is not.
    """

    path: str
    name: str
    size: tuple[int, int] | None
    sighting: Sighting | None
    why: str
    thumbnail: GreyImage | None
    turned: bool = False


@dataclass(frozen=True, eq=False)
class Detection:
    """Views found in photographs, and what was not.

    Attributes
    ----------
    photographs : tuple of Photograph
        All of them, in the order given.
    detector : str
        What found the points, with OpenCV's version.
    """

    views: Views
    photographs: tuple[Photograph, ...]
    pattern: Pattern
    detector: str

    @property
    def failed(self) -> tuple[Photograph, ...]:
        """Photographs that make no view."""
        return tuple(one for one in self.photographs if one.why)


def detect(
    images: str | Path | Sequence[str | Path],
    pattern: Pattern,
    progress: Callable[[str], None] = lambda _: None,
) -> Detection:
    """Find a target in photographs.

    Parameters
    ----------
    images : str, Path or sequence of them
        Files, or patterns of names such as ``"images/*.jpg"``.
    pattern : Pattern
        What to look for.
    progress : callable, optional
        Told the name of each photograph as it is begun.

    Raises
    ------
    InputError
        Where there are no such files, or the target is found in none of them.
    """
    paths = image_paths([images] if isinstance(images, str | Path) else images)
    pattern.target()  # complains of a board that can't be, before any work
    found = []
    for path, name in zip(paths, short_names(paths), strict=True):
        progress(name)
        found.append(_look(path, name, pattern))
    photographs = _of_one_size(found)
    used = [(one, one.sighting) for one in photographs if one.sighting is not None]
    if not used:
        one = photographs[0]
        raise InputError(
            f"no {pattern.name} was found in {len(photographs)} photographs ({one.name}: "
            f"{one.why}); check --pattern and --board (inner corners of a chessboard, squares of a "
            "ChArUco board)"
        )
    version = opencv().__version__
    detector = f"{pattern.method} of OpenCV {version}"
    return Detection(_views(used, pattern), photographs, pattern, detector)


def image_paths(given: Iterable[str | Path]) -> list[Path]:
    """Photographs that names and patterns of names mean; as `named_paths`."""
    return named_paths(given, "photographs", "images/*.jpg")


def _look(path: Path, name: str, pattern: Pattern) -> Photograph:
    """Read one photograph and look for the target in it."""
    try:
        if path.stat().st_size > LARGEST:
            return Photograph(str(path), name, None, None, "the file is too large", None)
        raw = path.read_bytes()
    except OSError as error:
        return Photograph(str(path), name, None, None, reason(error), None)
    image = decoded(raw)
    if image is None:
        return Photograph(str(path), name, None, None, "is no image that OpenCV reads", None)
    size, small = (image.shape[1], image.shape[0]), _small(image)
    try:
        sighting = pattern.find(image)
    except opencv().error as error:
        why = " ".join(str(error).split())
        return Photograph(str(path), name, size, None, f"OpenCV fails on it: {why}", small)
    why = "" if sighting is not None else f"no {pattern.name} found"
    if sighting is not None and not np.isfinite(sighting.pixels).all():
        sighting, why = None, "OpenCV places a corner nowhere"
    return Photograph(str(path), name, size, sighting, why, small, is_turned(raw))


def _small(image: GreyImage) -> GreyImage:
    cv2 = opencv()
    scale = THUMBNAIL / max(image.shape)
    size = tuple(max(round(side * scale), 1) for side in image.shape[::-1])
    small: GreyImage = cv2.resize(image, size, interpolation=cv2.INTER_AREA)
    return small


def _of_one_size(photographs: Sequence[Photograph]) -> tuple[Photograph, ...]:
    """Leave out photographs of another size than most."""
    sizes = Counter(one.size for one in photographs if one.sighting is not None)
    if len(sizes) < 2:
        return tuple(photographs)
    ((most, _),) = sizes.most_common(1)
    assert most is not None, "what was found was read"
    return tuple(
        one
        if one.size in (None, most)
        else replace(
            one,
            sighting=None,
            why=f"is {one.size[0]} by {one.size[1]} px, not {most[0]} by {most[1]}",
        )
        for one in photographs
    )


def _views(used: Sequence[tuple[Photograph, Sighting]], pattern: Pattern) -> Views:
    target = pattern.target()
    pixels = [np.round(sighting.pixels, DECIMALS) for _, sighting in used]
    digest = hashlib.sha256(b"".join(p.tobytes() for p in pixels)).hexdigest()
    size = used[0][0].size
    assert size is not None, "what was found was read"
    return Views.from_rows(
        [one.name for one, sighting in used for _ in sighting.points],
        np.concatenate([target[sighting.points] for _, sighting in used]),
        np.concatenate(pixels),
        width=size[0],
        height=size[1],
        source="photographs",
        sha256=digest,
        notes=_notes(used, pattern),
    )


def _notes(used: Sequence[tuple[Photograph, Sighting]], pattern: Pattern) -> tuple[str, ...]:
    turned = [one.name for one, _ in used if one.turned]
    found = [pattern.caution] if pattern.caution else []
    if turned:
        found.append(
            f"{counted(len(turned), 'photograph')} (the first {turned[0]}) would be shown turned "
            "by EXIF; pixels here are counted as the sensor has them"
        )
    return tuple(found)
