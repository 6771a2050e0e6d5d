"""The files of a run, whatever it holds: each checked before it is believed."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable, Container, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, Self, TypeVar

from bayescal.comparison.settings import Settings
from bayescal.errors import InputError
from bayescal.files import RESULT
from bayescal.inference.arviz_bridge import Draws, parse_netcdf
from bayescal.inference.sampled_model import SampledModel
from bayescal.inference.sampled_posterior import SampledPosterior
from bayescal.inference.stored import unpack_sampled
from bayescal.points.correspondences import Correspondences
from bayescal.points.reader import load
from bayescal.points.text import reason
from bayescal.report.document import versions
from bayescal.report.run import DRAWS, FORMAT, MANIFEST, POINTS, SETUP, digest
from bayescal.report.shape import misshapen
from bayescal.version import __version__

Kept = TypeVar("Kept")


@dataclass(frozen=True, eq=False)
class RunFiles:
    """The files of a run, each checked against its hash as it is read."""

    folder: Path
    manifest: dict[str, Any]
    document: dict[str, Any]

    # What the document must hold: of all, and of each axis (None: it has none); each kind of
    # run states its own.
    schema: ClassVar[str]
    made_by: ClassVar[str]
    shape: ClassVar[Mapping[str, Any]]
    axis_shape: ClassVar[Mapping[str, Any] | None]

    @classmethod
    def at(cls, folder: Path) -> Self:
        """Read what describes the run; refuse what this version can't make sense of."""
        if not is_run(folder):
            raise InputError(
                f"{folder}: {_no_run(folder)}; name a folder that {cls.made_by} --out wrote"
            )
        found = _json(folder / RESULT)
        schema = found.get("schema")
        if schema != cls.schema:
            raise InputError(
                f"{folder / RESULT}: holds {schema!r} where a run holds {cls.schema!r}; name a "
                f"folder that {cls.made_by} --out wrote"
            )
        run = cls(folder, {}, found)
        if not (folder / MANIFEST).is_file():
            raise InputError(
                f"{folder}: holds no {MANIFEST}, without which a run can't be reopened: it was "
                f"written by a bayescal that made none, or is incomplete; {run.again}"
            )
        run = cls(folder, _json(folder / MANIFEST), found)
        run.check()
        return run

    def check(self) -> None:
        """Refuse another format, and a document that was changed."""
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
        lacks = misshapen(self.document, self.shape, self.axis_shape)
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
        try:
            raw = (self.folder / name).read_bytes()
        except OSError as error:
            raise InputError(f"{self.folder / name}: {reason(error)}; {self.again}") from None
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
        read = load(self.folder / POINTS, self.folder / SETUP)
        lines, data = self.manifest.get("lines"), self.document["data"]
        if lines is not None and not (
            isinstance(lines, list)
            and len(lines) == len(read)
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

    def sampled(
        self,
        name: str,
        model: SampledModel,
        compute: Callable[[], SampledPosterior],  # noqa: ARG002 - nothing is sampled
    ) -> SampledPosterior:
        """Read the draws and the evidence of a model without a closed form."""
        return self.read_draws(name, lambda draws: unpack_sampled(draws, model))

    def read_draws(self, name: str, unpack: Callable[[Draws], Kept]) -> Kept:
        """Read the draws of a name, and make of them what they were."""
        place = f"{DRAWS}/{name}.nc"
        raw = self.content(place)
        try:
            return unpack(parse_netcdf(raw))
        except ValueError as error:
            raise InputError(f"{self.folder / place}: {error}; {self.again}") from None


def schema_of(folder: Path) -> object:
    """Say what a run holds: the schema its document names.

    Raises
    ------
    InputError
        Where the document can't be read.
    """
    return _json(folder / RESULT).get("schema")


def is_run(path: Path) -> bool:
    """Whether a path is a folder that holds a result document."""
    try:
        return (path / RESULT).is_file()
    except OSError:
        return False


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
        found = json.loads(path.read_bytes())
    except OSError as error:
        raise InputError(f"{path}: {reason(error)}; make the run again") from None
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: is not JSON ({reason(error)}); make the run again") from None
    if not isinstance(found, dict):
        raise InputError(f"{path}: is not a JSON object; make the run again")
    return found
