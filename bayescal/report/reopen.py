"""Reopens a run: the draws are read, what has a closed form is computed again and checked."""

from __future__ import annotations

import dataclasses
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import bayescal
from bayescal.analysis import analyse_points
from bayescal.comparison.noise_evidence import NoiseEvidence
from bayescal.comparison.results import Comparison
from bayescal.errors import InputError
from bayescal.files import RESULT
from bayescal.inference.arviz_bridge import parse_netcdf
from bayescal.inference.closed_form import exact_posterior
from bayescal.inference.model import LinearModel
from bayescal.inference.posterior import Posterior, posterior_of
from bayescal.inference.sampled_model import SampledModel
from bayescal.inference.sampled_posterior import SampledPosterior
from bayescal.inference.stored import unpack, unpack_sampled
from bayescal.models import separable
from bayescal.points.correspondences import Correspondences
from bayescal.points.reader import load
from bayescal.points.text import reason
from bayescal.report.agreement import disagreement
from bayescal.report.document import SCHEMA, document, versions
from bayescal.report.other_noises import noises_from
from bayescal.report.run import DRAWS, FORMAT, MANIFEST, POINTS, SETUP, digest
from bayescal.report.shape import misshapen
from bayescal.settings import Settings


def open_run(folder: str | Path, *, defend: bool | None = None) -> Comparison:
    """Read a comparison back from the folder that ``--out`` or `save_run` wrote.

    Nothing is sampled: the draws are read. What follows from points and draws without
    chance is computed again and compared with what the run says.

    Parameters
    ----------
    folder : str or Path
    defend : bool, optional
        Whether to answer a referee's questions too; by default where the run does.

    Returns
    -------
    Comparison

    Raises
    ------
    InputError
        Where the folder is no run, was written by a version whose runs this one can't
        read, is incomplete, was changed, or says other numbers than computed now.
    """
    run = _Run.at(Path(folder))
    settings = run.settings
    if defend is not None:
        settings = dataclasses.replace(settings, defend=defend)
    comparison = analyse_points(run.points(), run.orders, settings, None, run)
    wrong = disagreement(run.document, document(comparison, ""))
    if wrong is not None:
        raise InputError(f"{run.folder}: {wrong}: {run.between()}; {run.again}")
    # With other answers than the run's it is no longer what the run holds.
    same = settings == run.settings
    hint = run.document.get("families", {}).get("hint")
    origin = run.document["provenance"] if same else None
    return dataclasses.replace(comparison, origin=origin, hint=hint)


@dataclass(frozen=True, eq=False)
class _Run:
    """The files of a run, each checked against its hash as it is read."""

    folder: Path
    manifest: dict[str, Any]
    document: dict[str, Any]

    @classmethod
    def at(cls, folder: Path) -> _Run:
        """Read what describes the run; refuse what this version can't make sense of."""
        if not is_run(folder):
            raise InputError(f"{folder}: {_no_run(folder)}; name a folder that compare --out wrote")
        found = _json(folder / RESULT)
        schema = found.get("schema")
        if schema != SCHEMA:
            raise InputError(
                f"{folder / RESULT}: holds {schema!r} where a run holds {SCHEMA!r}; name a folder "
                "that compare --out wrote"
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
                f"bayescal {bayescal.__version__} reads format {FORMAT}; install bayescal "
                f"{writer}, or {self.again}"
            )
        self.content(RESULT)
        lacks = misshapen(self.document)
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

    @property
    def settings(self) -> Settings:
        """What was asked for."""
        stated = self.document["settings"]
        known = {field.name for field in dataclasses.fields(Settings)}
        strange = sorted(set(stated) - known)
        if strange:
            raise InputError(
                f"{self.folder}: was made with the setting {strange[0]!r}, which bayescal "
                f"{bayescal.__version__} does not have ({self.between()}); upgrade bayescal"
            )
        try:
            return Settings(**stated)
        except InputError as error:
            raise InputError(
                f"{self.folder / RESULT}: {error} ({self.between()}); {self.again}"
            ) from None

    @property
    def orders(self) -> dict[str, tuple[int, ...]]:
        """Orders compared, by axis."""
        family = self.document["family"]
        if family != separable.NAME:
            raise InputError(
                f"{self.folder}: is of the family {family!r}, which bayescal "
                f"{bayescal.__version__} does not have ({self.between()}); upgrade bayescal"
            )
        axes = self.document["axes"]
        return {name: tuple(o["order"] for o in axis["orders"]) for name, axis in axes.items()}

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
        return dataclasses.replace(
            read,
            source=data["source"],
            sha256=data["sha256"],
            lines=None if lines is None else tuple(lines),
        )

    def posterior(
        self,
        name: str,
        model: LinearModel,
        rng: np.random.Generator,  # noqa: ARG002 - nothing is sampled
        ess: int,  # noqa: ARG002
    ) -> Posterior:
        """Read a model's draws (as a `bayescal.analysis.Source`)."""
        place = f"{DRAWS}/{name}.nc"
        raw = self.content(place)
        try:
            chain = unpack(parse_netcdf(raw), model.names)
        except ValueError as error:
            raise InputError(f"{self.folder / place}: {error}; {self.again}") from None
        return posterior_of(exact_posterior(model), chain)

    def sampled(
        self,
        name: str,
        model: SampledModel,
        rng: np.random.Generator,  # noqa: ARG002 - nothing is sampled
        ess: int,  # noqa: ARG002
    ) -> SampledPosterior:
        """Read the draws and the evidence of a model without a closed form."""
        place = f"{DRAWS}/{name}.nc"
        raw = self.content(place)
        try:
            return unpack_sampled(parse_netcdf(raw), model)
        except ValueError as error:
            raise InputError(f"{self.folder / place}: {error}; {self.again}") from None

    def noises(self, axis: str) -> tuple[NoiseEvidence, ...] | None:
        """Evidence under other noise models, where the run's defence has it."""
        defence = self.document["axes"][axis]["defence"]
        return None if defence is None else noises_from(defence["noises"])

    def wins(self, axis: str, unit: str) -> dict[int, float] | None:
        """Bootstrap shares of an axis, which take most of a defence's time."""
        defence = self.document["axes"][axis]["defence"]
        for found in defence["bootstrap"] if defence is not None else []:
            if found["unit"] == unit:
                return {int(k): share for k, share in found["share"].items()}
        return None


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
