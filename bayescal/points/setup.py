"""What is known of the camera, and the TOML file that says it.

A setup file has the tables ``[camera]`` (position and, where it is not exact, position_sd,
world units; orientation and orientation_sd, degrees), ``[image]`` (width, height,
c_from_bottom, assumed) and, where the user states their own priors,
``[prior.r]`` and ``[prior.c]`` (mean, sd: px, one entry per Legendre amplitude) and
``[prior.pinhole]`` (focal, centre, centre_sd: px; focal_log_sd, ratio_log_sd); where
the world coordinates have errors, ``[world]`` (sigma: of x, y, z, world units).
"""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from bayescal.errors import InputError
from bayescal.points.camera import CAMERA_KEYS, PINHOLE_KEYS, StatedCamera
from bayescal.points.tables.content import LARGEST_SETUP, read_file

AXES = ("r", "c")
_KEYS = {
    "": {"camera", "image", "prior", "world"},
    "camera": {"position", *CAMERA_KEYS},
    "image": {"width", "height", "c_from_bottom", "assumed"},
    "prior": {*AXES, "pinhole"},
    "world": {"sigma"},
    "prior.r": {"mean", "sd"},
    "prior.c": {"mean", "sd"},
    "prior.pinhole": set(PINHOLE_KEYS),
}
# Where a setup's value stands in the file, if not in [image] under its own name.
PLACES = {"position": "camera.position", "world_sigma": "world.sigma"}
_ASSUMABLE = ("position", "width", "height", "c_from_bottom")
# Squares of numbers beyond this overflow a double somewhere downstream; no world
# coordinate is that large in any unit.
LARGEST = 1e100
# What a pixel may be, and how finely one can be known: beyond these no double tells
# a residual from rounding.
LARGEST_PX, SMALLEST_PX = 1e9, 1e-6


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
        object.__setattr__(self, "mean", _floats(self.mean))
        object.__setattr__(self, "sd", _floats(self.sd))
        if len(self.mean) != len(self.sd):
            raise InputError(
                f"mean has {len(self.mean)} entries and sd {len(self.sd)}; give both for each b_j"
            )
        if not all(abs(m) <= LARGEST_PX for m in self.mean):
            raise InputError(f"every mean must be finite and at most {LARGEST_PX:g} px")
        if not all(SMALLEST_PX <= s <= LARGEST_PX for s in self.sd):
            raise InputError(f"every sd must be from {SMALLEST_PX:g} to {LARGEST_PX:g} px")


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
    world_sigma : tuple of float or None
        Standard deviations of the world coordinates x, y, z, world units.
    camera : StatedCamera
        How sure the position is, the orientation and the optics, as far as stated.
    """

    position: tuple[float, float, float] = (0.0, 0.0, 0.0)
    width: float | None = None
    height: float | None = None
    c_from_bottom: bool = False
    assumed: tuple[str, ...] = ()
    priors: dict[str, StatedPrior] = field(default_factory=dict)
    world_sigma: tuple[float, float, float] | None = None
    camera: StatedCamera = field(default_factory=StatedCamera)

    def __post_init__(self) -> None:
        # Floats, whatever numbers they come as, so that a setup file gives back the same.
        object.__setattr__(self, "position", _floats(self.position))
        for name in ("width", "height"):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, _float(getattr(self, name)))
        if self.world_sigma is not None:
            object.__setattr__(self, "world_sigma", _floats(self.world_sigma))
        if not all(abs(v) < LARGEST for v in self.position):
            raise InputError(
                f"the camera position must be three finite numbers below {LARGEST:g}; mend it"
            )
        for name, size in (("width", self.width), ("height", self.height)):
            if size is not None and not 1 <= size <= LARGEST_PX:
                raise InputError(f"image {name} must be from 1 to {LARGEST_PX:g} px, not {size:g}")
        if self.world_sigma is not None and not all(0 <= s < LARGEST for s in self.world_sigma):
            raise InputError("deviations of x, y, z must be finite and not negative")
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
    name = str(path)
    text = read_file(path, "a TOML setup file", LARGEST_SETUP).text()
    try:
        document = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(_not_toml(name, text, str(error))) from None
    except (RecursionError, ValueError):  # ValueError: more digits than Python converts
        raise InputError(f"{name}: nested too deeply, or a number too long; mend it") from None
    return _Parser(name, text, document).setup()


def _not_toml(name: str, text: str, message: str) -> str:
    """Say what is not TOML, with the line first as everywhere."""
    what, _, place = message.partition(" (at ")
    found = re.match(r"line (\d+)", place)
    line = int(found[1]) if found else text.rstrip().count("\n") + 1
    return f"{name}:{line}: is not valid TOML: {what}; mend it"


class _Parser:
    """Turns a TOML document into a Setup, naming the line of every complaint."""

    def __init__(self, path: str, text: str, document: dict[str, Any]) -> None:
        self.path, self.text, self.document = path, text, document

    def fail(self, key: str, what: str) -> InputError:
        return InputError(f"{self.place(key)}: {key}: {what}")

    def place(self, key: str) -> str:
        """File and line of a key, or of the table nearest to it."""
        table, nearest = "", None
        for number, line in enumerate(self.text.split("\n"), 1):
            header = re.match(r"\s*\[\[?([^\[\]]*)\]", line)
            assigned = re.match(r"([^=#]*)=", line)
            if header:
                here = table = _normal(header[1])
            elif assigned:
                here = _normal(f"{table}.{assigned[1]}" if table else assigned[1])
            else:
                continue
            if here == key:
                return f"{self.path}:{number}"
            if key.startswith(f"{here}.") or here.startswith(f"{key}."):
                nearest = number
        return self.path if nearest is None else f"{self.path}:{nearest}"

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
            many = "" if count is None else f"{count} "
            raise self.fail(key, f"must be a list of {many}numbers")
        if count is not None and len(values) != count:
            raise self.fail(key, f"must have {count} numbers, not {len(values)}")
        return tuple(_float(v) for v in values)

    def setup(self) -> Setup:
        self.table("")
        stated = {axis: self.prior(axis) for axis in self.table("prior") if axis in AXES}
        found = Setup(priors=stated, camera=self.camera())
        camera, image = self.table("camera"), self.table("image")
        given: dict[str, Any] = {}
        if "position" in camera:
            given["position"] = self.numbers(camera, "camera.position", 3)
        for name in ("width", "height"):
            if name in image:
                if not _is_number(image[name]):
                    raise self.fail(f"image.{name}", "must be a number of px")
                given[name] = _float(image[name])
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
        world = self.table("world")
        if "sigma" in world:
            given["world_sigma"] = self.numbers(world, "world.sigma", 3)
        for name, value in given.items():  # one by one, so that a complaint has its line
            try:
                found = replace(found, **{name: value})
            except InputError as error:
                key = PLACES.get(name, f"image.{name}")
                raise InputError(f"{self.place(key)}: {error}") from None
        return found

    def camera(self) -> StatedCamera:
        found = StatedCamera()
        for table, keys in (("camera", CAMERA_KEYS), ("prior.pinhole", PINHOLE_KEYS)):
            given = self.table(table)
            for name in given.keys() & keys:
                key, count = f"{table}.{name}", keys[name]
                value: Any = given[name]
                if count > 1:
                    value = self.numbers(given, key, count)
                elif _is_number(value):
                    value = _float(value)
                else:
                    raise self.fail(key, "must be a number")
                try:  # one by one, so that a complaint has its line
                    found = replace(found, **{name: value})
                except InputError as error:
                    raise InputError(f"{self.place(key)}: {error}") from None
        return found

    def prior(self, axis: str) -> StatedPrior:
        key = f"prior.{axis}"
        table = self.table(key)
        mean, sd = (self.numbers(table, f"{key}.{name}", None) for name in ("mean", "sd"))
        try:
            return StatedPrior(mean, sd)
        except InputError as error:
            raise self.fail(key, str(error)) from None


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _float(value: float) -> float:
    """Convert a number; an integer beyond every double becomes infinite."""
    try:
        return float(value)
    except OverflowError:
        return math.inf


def _floats(values: Iterable[float]) -> tuple[float, ...]:
    return tuple(_float(v) for v in values)


def _normal(key: str) -> str:
    """Bring a key as written in TOML to the form a.b.c."""
    return ".".join(part.strip(" \t\"'") for part in key.split("."))
