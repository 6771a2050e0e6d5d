"""The files of a run, whatever it holds: each checked before it is believed."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable, Container
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from bayescal.arrays import DAMAGE
from bayescal.comparison.settings import Settings
from bayescal.encoding import Encoded
from bayescal.errors import InputError
from bayescal.files import RESULT
from bayescal.inference.arviz_bridge import Draws, parse_netcdf
from bayescal.points.chunks.many import many_points
from bayescal.points.correspondences import Correspondences
from bayescal.points.reader import load
from bayescal.points.setup_file import load_setup
from bayescal.points.tables.text import reason
from bayescal.points.views.reader import load_views
from bayescal.points.views.views import Views
from bayescal.polynomials.whole import Whole
from bayescal.report.document.shared import stated_heading, versions
from bayescal.report.run.bounded import bounded
from bayescal.report.run.folder import (
    DERIVED,
    DRAWS,
    FORMAT,
    MADE_OF,
    MANIFEST,
    POINTS,
    SETUP,
    VIEWS,
    digest,
    made_of,
)
from bayescal.report.run.reduction import REDUCTION, parse_reduction
from bayescal.report.run.shape import misshapen
from bayescal.version import __version__

Kept = TypeVar("Kept")
Rows = TypeVar("Rows", Correspondences, Views)


@dataclass(frozen=True, eq=False)
class RunFiles:
    """The files of a run, each checked against its hash as it is read."""

    folder: Path
    manifest: dict[str, Any]
    document: dict[str, Any]

    @classmethod
    def at(cls, folder: Path, schema: str, made_by: str, shape: Any) -> RunFiles:
        """Read what describes a run of one schema; refuse what this version can't make sense of."""
        document = document_at(folder, made_by)
        if document.get("schema") != schema:
            raise InputError(
                f"{folder / RESULT}: holds {document.get('schema')!r} where a run holds "
                f"{schema!r}; name a folder that {made_by} --out wrote"
            )
        run = cls(folder, {}, document)
        if not (folder / MANIFEST).is_file():
            raise InputError(
                f"{folder}: holds no {MANIFEST}, without which a run can't be reopened: it was "
                f"written by a bayescal that made none, or is incomplete; {run.again}"
            )
        run = cls(folder, _json(folder / MANIFEST), document)
        run.check(shape)
        return run

    def check(self, shape: Any) -> None:
        """Refuse another format, and a document that was changed or is of another shape."""
        number, writer = self.manifest.get("format"), self.manifest.get("bayescal")
        if not isinstance(number, int) or not isinstance(self.manifest.get("files"), dict):
            raise InputError(f"{self.folder / MANIFEST}: is damaged: names no format; {self.again}")
        if number != FORMAT:
            raise InputError(
                f"{self.folder}: is a run of format {number}, written by bayescal {writer}; "
                f"bayescal {__version__} reads format {FORMAT}; install bayescal "
                f"{writer}, or {self.again}"
            )
        self.content(RESULT)
        lacks = misshapen(self.document, shape)
        if lacks is not None:
            raise InputError(
                f"{self.folder / RESULT}: is damaged: {lacks} is missing or not what belongs "
                f"there; {self.again}"
            )

    @property
    def again(self) -> str:
        """How to have the run anew, for messages."""
        try:
            return f"make it again: {self.document['provenance']['command']}"
        except (KeyError, TypeError):
            return "make it again"

    def between(self) -> str:
        """Who wrote the run and who reads it."""
        wrote, reads = self.document["provenance"], versions()
        differ = {name: now for name, now in reads.items() if wrote.get(name) != now}
        if not differ:
            return "the same versions wrote and read it, so its files or the machine are at fault"
        then = ", ".join(f"{name} {wrote.get(name)}" for name in differ)
        now = ", ".join(f"{name} {version}" for name, version in differ.items())
        return f"written by {then}, read by {now}"

    def content(self, name: str) -> bytes:
        """Read a file of the run; refuse one that is not what was written."""
        expected = self.manifest["files"].get(name)
        raw = bounded(self.folder / name, self.again)
        if digest(raw) != expected:
            raise InputError(
                f"{self.folder / name}: is not what was written there (its SHA-256 differs from "
                f"the one in {MANIFEST}): changed or cut off; restore it, or {self.again}"
            )
        return raw

    def settings(self, beside: Container[str] = ()) -> Settings:
        """Give what was asked for, as the document says; keys `beside` it are left alone.

        Raises
        ------
        InputError
            Where this version does not have a setting, or it is not usable.
        """
        stated = {k: v for k, v in self.document["settings"].items() if k not in beside}
        known = {field.name for field in dataclasses.fields(Settings)}
        strange = sorted(set(stated) - known)
        if strange:
            raise InputError(
                f"{self.folder}: was made with the setting {strange[0]!r}, which bayescal "
                f"{__version__} does not have ({self.between()}); upgrade bayescal"
            )
        try:
            return Settings(**stated)
        except InputError as error:
            raise self.unusable(error) from None

    def unusable(self, error: Exception) -> InputError:
        """Make the complaint where what was asked for is not usable here."""
        return InputError(f"{self.folder / RESULT}: {error} ({self.between()}); {self.again}")

    def points(self) -> Correspondences:
        """Read the points, which name the source they once came from."""
        for name in (POINTS, SETUP):
            self.content(name)
        setup, many = load_setup(self.folder / SETUP), many_points(self.folder / POINTS)
        if many is not None:
            read = dataclasses.replace(many, setup=setup).at_once()
        else:
            read = load(self.folder / POINTS, setup)
        read = self._named(read)
        of = self.document["data"]["n_points"] if REDUCTION in self.manifest["files"] else None
        return dataclasses.replace(read, drawn_from=of)

    def views(self) -> Views:
        """Read the views, which name the source they once came from."""
        self.content(VIEWS)
        read = self._named(load_views(self.folder / VIEWS))
        return dataclasses.replace(read, heading=stated_heading(self.document))

    def _named(self, read: Rows) -> Rows:
        """Give what was read the source, the lines and the notes it once had."""
        lines, data = self.manifest.get("lines"), self.document["data"]
        if lines is not None and not (
            isinstance(lines, list)
            and len(lines) == len(read.pixels)
            and all(isinstance(line, int) for line in lines)
        ):
            raise InputError(f"{self.folder / MANIFEST}: is damaged: lines; {self.again}")
        notes = self.manifest.get("notes", [])
        if not isinstance(notes, list) or not all(isinstance(note, str) for note in notes):
            raise InputError(f"{self.folder / MANIFEST}: is damaged: notes; {self.again}")
        return dataclasses.replace(
            read,
            source=data["source"],
            sha256=data["sha256"],
            lines=None if lines is None else tuple(lines),
            notes=tuple(notes),
        )

    def whole(self) -> dict[str, Whole] | None:
        """Read the reduction of many points; None where the run holds them all."""
        if REDUCTION not in self.manifest["files"]:
            return None
        raw = self.content(REDUCTION)
        try:
            return parse_reduction(raw)
        except DAMAGE as error:
            where = self.folder / REDUCTION
            raise InputError(f"{where}: is damaged: {error}; {self.again}") from None

    def derived_value(self, name: str, kind: Any) -> tuple[Any] | None:
        """Read a value that took long, alone in a tuple; None where the run kept none.

        Nor where it was made of other points, another camera, other settings or by another
        version: then it is computed again.
        """
        kept = self._derived
        if name not in kept:
            return None
        try:
            return (kept.value(name, kind),)
        except ValueError as error:
            raise InputError(f"{self.folder / DERIVED}: {error}; {self.again}") from None

    @property
    def derives(self) -> bool:
        """Whether it keeps what took long, of these points and settings."""
        return bool(self._derived.values)

    @cached_property
    def _derived(self) -> Encoded:
        none = Encoded({}, np.empty(0))
        if DERIVED not in self.manifest["files"]:
            return none
        raw = self.content(DERIVED)
        try:
            found = Encoded.parse(raw)
            made_of_these = MADE_OF in found and found.value(MADE_OF, str) == made_of(self.folder)
        except ValueError as error:
            where = self.folder / DERIVED
            raise InputError(f"{where}: is damaged: {error}; {self.again}") from None
        return found if made_of_these else none

    def keeps_draws(self, name: str) -> bool:
        """Whether draws of a name were written."""
        return f"{DRAWS}/{name}.nc" in self.manifest["files"]

    def read_draws(self, name: str, unpack: Callable[[Draws], Kept]) -> Kept:
        """Read the draws of a name, and make of them what they were."""
        place = f"{DRAWS}/{name}.nc"
        raw = self.content(place)
        try:
            return unpack(parse_netcdf(raw))
        except ValueError as error:
            raise InputError(f"{self.folder / place}: {error}; {self.again}") from None


def document_at(folder: Path, made_by: str) -> dict[str, Any]:
    """Read the document of a run; refuse a place that is none."""
    try:
        there = (folder / RESULT).is_file()
    except OSError:
        there = False
    if not there:
        raise InputError(f"{folder}: {_no_run(folder)}; name a folder that {made_by} --out wrote")
    return _json(folder / RESULT)


def _no_run(folder: Path) -> str:
    """Why a path is no run."""
    try:
        names = [entry.name for entry in folder.iterdir()]
    except (OSError, ValueError) as error:
        return reason(error)
    return f"is not a run: it holds no {RESULT}" + (", nor anything else" if not names else "")


def _json(path: Path) -> dict[str, Any]:
    """Read a JSON object."""
    try:
        found = json.loads(bounded(path, "make the run again"))
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: is not JSON ({reason(error)}); make the run again") from None
    if not isinstance(found, dict):
        raise InputError(f"{path}: is not a JSON object; make the run again")
    return found
