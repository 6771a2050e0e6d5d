"""What is known of the camera, and the TOML file that says it.

A setup file has the tables ``[camera]`` (position), ``[image]`` (width, height,
c_from_bottom, assumed) and, where the user states their own priors,
``[prior.r]`` and ``[prior.c]`` (mean, sd: px, one entry per Legendre amplitude).
"""

from __future__ import annotations

import math
import re
import tomllib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from bayescal.errors import InputError

AXES = ("r", "c")
_KEYS = {
    "": {"camera", "image", "prior"},
    "camera": {"position"},
    "image": {"width", "height", "c_from_bottom", "assumed"},
    "prior": set(AXES),
    "prior.r": {"mean", "sd"},
    "prior.c": {"mean", "sd"},
}
_ASSUMABLE = ("position", "width", "height", "c_from_bottom")


@dataclass(frozen=True)
class StatedPrior:
    """A normal prior for each Legendre amplitude, as a user states it.

    Attributes
    ----------
    mean, sd : tuple of float
        Means and standard deviations of b_0, b_1, ..., px.
    """

    mean: tuple[float, ...]
    sd: tuple[float, ...]

    def __post_init__(self) -> None:
        if len(self.mean) != len(self.sd):
            raise InputError(
                f"mean has {len(self.mean)} entries and sd {len(self.sd)}; give both for each b_j"
            )
        if not all(math.isfinite(m) for m in self.mean):
            raise InputError("every mean must be finite")
        if not all(math.isfinite(s) and s > 0 for s in self.sd):
            raise InputError("every sd must be positive and finite")


@dataclass(frozen=True)
class Setup:
    """What is known of the camera.

    Attributes
    ----------
    position : tuple of float
        Camera position x, y, z, world units; subtracted from the world points.
    width, height : float or None
        Image size, px; None where it is not known.
    c_from_bottom : bool
        Whether c is counted from the bottom: c = height - recorded row.
    assumed : tuple of str
        Which of these are assumptions rather than the source's statement.
    priors : dict of str to StatedPrior
        The user's own priors by axis.
    """

    position: tuple[float, float, float] = (0.0, 0.0, 0.0)
    width: float | None = None
    height: float | None = None
    c_from_bottom: bool = False
    assumed: tuple[str, ...] = ()
    priors: dict[str, StatedPrior] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not all(math.isfinite(v) for v in self.position):
            raise InputError("the camera position must be three finite numbers")
        for name, size in (("width", self.width), ("height", self.height)):
            if size is not None and not (math.isfinite(size) and 0 < size < 1e9):
                raise InputError(f"image {name} must be a positive number of px, not {size}")
        if self.c_from_bottom and self.height is None:
            raise InputError("c counted from the bottom needs the image height; give it")

    def size(self, axis: str) -> float | None:
        """Image size along an axis, px: width for r, height for c."""
        return self.width if axis == "r" else self.height


def load_setup(path: str | Path) -> Setup:
    """Read a setup file.

    Parameters
    ----------
    path : str or Path
        A TOML file (see the module's description).

    Raises
    ------
    InputError
        Where the file can't be read, is not TOML, or has an unknown key or a
        value of the wrong kind; the message names the line.
    """
    try:
        text = Path(path).read_bytes().decode("utf-8-sig")
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: {reason(error)}; give a TOML setup file") from None
    try:
        document = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{path}: not valid TOML: {_one_line(error)}") from None
    parser = _Parser(str(path), text, document)
    return parser.setup()


def reason(error: Exception) -> str:
    """Say in a few words why a file could not be read."""
    if isinstance(error, IsADirectoryError):
        return "is a directory"
    if isinstance(error, FileNotFoundError):
        return "there is no such file"
    if isinstance(error, UnicodeDecodeError):
        return f"is not UTF-8 text (byte {error.start})"
    if isinstance(error, OSError) and error.strerror:
        return error.strerror.lower()
    return _one_line(error)


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split())


class _Parser:
    """Turns a TOML document into a Setup, naming the line of every complaint."""

    def __init__(self, path: str, text: str, document: dict[str, Any]) -> None:
        self.path, self.text, self.document = path, text, document

    def fail(self, key: str, what: str) -> InputError:
        leaf = re.escape(key.rsplit(".", 1)[-1])
        pattern = re.compile(rf"^\s*(\[.*\b{leaf}\s*\]|[\w.\"' -]*\b{leaf}[\"']?\s*=)")
        for number, line in enumerate(self.text.splitlines(), 1):
            if pattern.match(line):
                return InputError(f"{self.path}:{number}: {key}: {what}")
        return InputError(f"{self.path}: {key}: {what}")

    def table(self, key: str) -> dict[str, Any]:
        node: Any = self.document
        for part in filter(None, key.split(".")):
            node = node.get(part, {})
        if not isinstance(node, dict):
            raise self.fail(key, f"must be a table, [{key}]")
        for name in node:
            if name not in _KEYS[key]:
                full = f"{key}.{name}" if key else name
                raise self.fail(full, f"unknown key; known here: {', '.join(sorted(_KEYS[key]))}")
        return node

    def numbers(self, table: dict[str, Any], key: str, count: int | None) -> tuple[float, ...]:
        values = table.get(key.rsplit(".", 1)[-1])
        if not isinstance(values, list) or not all(_is_number(v) for v in values):
            raise self.fail(key, "must be a list of numbers")
        if count is not None and len(values) != count:
            raise self.fail(key, f"must have {count} numbers, not {len(values)}")
        return tuple(float(v) for v in values)

    def setup(self) -> Setup:
        self.table("")
        camera, image = self.table("camera"), self.table("image")
        given: dict[str, Any] = {}
        if "position" in camera:
            given["position"] = self.numbers(camera, "camera.position", 3)
        for name in ("width", "height"):
            if name in image:
                if not _is_number(image[name]):
                    raise self.fail(f"image.{name}", "must be a number of px")
                given[name] = float(image[name])
        if "c_from_bottom" in image:
            if not isinstance(image["c_from_bottom"], bool):
                raise self.fail("image.c_from_bottom", "must be true or false")
            given["c_from_bottom"] = image["c_from_bottom"]
        if "assumed" in image:
            assumed = image["assumed"]
            if not isinstance(assumed, list) or not all(a in _ASSUMABLE for a in assumed):
                raise self.fail(
                    "image.assumed", f"must be a list of names among {', '.join(_ASSUMABLE)}"
                )
            given["assumed"] = tuple(assumed)
        given["priors"] = {axis: self.prior(axis) for axis in self.table("prior")}
        try:
            return Setup(**given)
        except InputError as error:
            raise InputError(f"{self.path}: {error}") from None

    def prior(self, axis: str) -> StatedPrior:
        key = f"prior.{axis}"
        table = self.table(key)
        try:
            return StatedPrior(
                self.numbers(table, f"{key}.mean", None), self.numbers(table, f"{key}.sd", None)
            )
        except InputError as error:
            message = str(error)
            if message.startswith(self.path):
                raise
            raise self.fail(key, message) from None


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
