"""The TOML file that says what is known of the camera.

It has the tables ``[camera]`` (position and, where it is not exact, position_sd,
world units; orientation and orientation_sd, degrees), ``[image]`` (width, height,
c_from_bottom, assumed) and, where the user states their own priors,
``[prior.r]`` and ``[prior.c]`` (mean, sd: px, one entry per Legendre amplitude) and
``[prior.pinhole]`` (focal, centre, centre_sd: px; focal_log_sd, ratio_log_sd); where
the world coordinates have errors, ``[world]`` (sigma: of x, y, z, world units); and
``[report]`` for the title block (title, camera, serial, operator: text).
"""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

from bayescal.errors import InputError
from bayescal.points.camera import CAMERA_KEYS, PINHOLE_KEYS, StatedCamera
from bayescal.points.heading import SILENT, Heading
from bayescal.points.setup import AXES, Setup, StatedPrior, number
from bayescal.points.tables.content import LARGEST_SETUP, read_file

Stated = TypeVar("Stated", Setup, StatedCamera, Heading)

_KEYS = {
    "": {"camera", "image", "prior", "report", "world"},
    "camera": {"position", *CAMERA_KEYS},
    "image": {"width", "height", "c_from_bottom", "assumed"},
    "prior": {*AXES, "pinhole"},
    "report": set(SILENT.facts),
    "world": {"sigma"},
    "prior.r": {"mean", "sd"},
    "prior.c": {"mean", "sd"},
    "prior.pinhole": set(PINHOLE_KEYS),
}
# Where a setup's value stands in the file, if not in [image] under its own name.
_PLACES = {"position": "camera.position", "world_sigma": "world.sigma"}
_ASSUMABLE = ("position", "width", "height", "c_from_bottom")


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
        raise InputError(f"{name}: nested too deeply, or a number too long; correct it") from None
    return _Parser(name, text, document).setup()


def _not_toml(name: str, text: str, message: str) -> str:
    """Say what is not TOML, with the line first as everywhere."""
    what, _, place = message.partition(" (at ")
    found = re.match(r"line (\d+)", place)
    line = int(found[1]) if found else text.rstrip().count("\n") + 1
    return f"{name}:{line}: is not valid TOML: {what}; correct it"


class _Parser:
    """Turns a TOML document into a Setup, naming the line of every complaint."""

    def __init__(self, path: str, text: str, document: dict[str, Any]) -> None:
        self.path, self.text, self.document = path, text, document

    def fail(self, key: str, what: str) -> InputError:
        return InputError(f"{self.place(key)}: {key}: {what}")

    def place(self, key: str) -> str:
        """File and line of a key, or of the table nearest to it."""
        table, nearest = "", None
        for row, line in enumerate(self.text.split("\n"), 1):
            header = re.match(r"\s*\[\[?([^\[\]]*)\]", line)
            assigned = re.match(r"([^=#]*)=", line)
            if header:
                here = table = _normal(header[1])
            elif assigned:
                here = _normal(f"{table}.{assigned[1]}" if table else assigned[1])
            else:
                continue
            if here == key:
                return f"{self.path}:{row}"
            if key.startswith(f"{here}.") or here.startswith(f"{key}."):
                nearest = row
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
        return tuple(number(v) for v in values)

    def setup(self) -> Setup:
        self.table("")
        stated = {axis: self.prior(axis) for axis in self.table("prior") if axis in AXES}
        found = Setup(priors=stated, camera=self.camera(), heading=self.heading())
        camera, image = self.table("camera"), self.table("image")
        given: dict[str, Any] = {}
        if "position" in camera:
            given["position"] = self.numbers(camera, "camera.position", 3)
        for name in ("width", "height"):
            if name in image:
                if not _is_number(image[name]):
                    raise self.fail(f"image.{name}", "must be a number of px")
                given[name] = number(image[name])
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
        for name, value in given.items():
            found = self.with_stated(found, name, value, _PLACES.get(name, f"image.{name}"))
        return found

    def with_stated(self, found: Stated, name: str, value: Any, key: str) -> Stated:
        """Add one value, so that a complaint of it has its line."""
        try:
            return replace(found, **{name: value})
        except InputError as error:
            raise InputError(f"{self.place(key)}: {error}") from None

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
                    value = number(value)
                else:
                    raise self.fail(key, "must be a number")
                found = self.with_stated(found, name, value, key)
        return found

    def heading(self) -> Heading:
        found = SILENT
        for name, text in self.table("report").items():
            found = self.with_stated(found, name, text, f"report.{name}")
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


def _normal(key: str) -> str:
    """Bring a key as written in TOML to the form a.b.c."""
    return ".".join(part.strip(" \t\"'") for part in key.split("."))


def to_toml(setup: Setup) -> str:
    """Format a setup as TOML text; every number survives the round trip.

    Returns
    -------
    str
    """
    lines = ["[camera]", f"position = {_list(setup.position)}"]
    lines += _stated(setup.camera, CAMERA_KEYS)
    lines += ["", "[image]"]
    lines += [
        f"{name} = {size!r}"
        for name, size in (("width", setup.width), ("height", setup.height))
        if size is not None
    ]
    lines.append(f"c_from_bottom = {str(setup.c_from_bottom).lower()}")
    lines.append("assumed = [" + ", ".join(f'"{name}"' for name in setup.assumed) + "]")
    if setup.world_sigma is not None:
        lines += ["", "[world]", f"sigma = {_list(setup.world_sigma)}"]
    for axis, prior in setup.priors.items():
        lines += ["", f"[prior.{axis}]", f"mean = {_list(prior.mean)}", f"sd = {_list(prior.sd)}"]
    optics = _stated(setup.camera, PINHOLE_KEYS)
    if optics:
        lines += ["", "[prior.pinhole]", *optics]
    said = [(name, text) for name, text in setup.heading.facts.items() if text is not None]
    if said:  # JSON's strings are TOML's, of printable text
        lines += ["", "[report]", *(f"{k} = {json.dumps(v, ensure_ascii=False)}" for k, v in said)]
    return "\n".join(lines) + "\n"


def _stated(camera: StatedCamera, keys: Iterable[str]) -> list[str]:
    """Lines of what is stated of the camera under some keys."""
    known = [(key, getattr(camera, key)) for key in keys if getattr(camera, key) is not None]
    return [f"{key} = {_list(v) if isinstance(v, tuple) else repr(v)}" for key, v in known]


def _list(values: tuple[float, ...]) -> str:
    return "[" + ", ".join(repr(v) for v in values) + "]"
