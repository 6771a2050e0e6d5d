"""A comparison across families as a run: written, and reopened without sampling."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bayescal.arrays import Array
from bayescal.comparison.families.analysis import compare_joint
from bayescal.comparison.families.results import FamilyComparison, FamilyRequest, JointModel
from bayescal.errors import InputError
from bayescal.inference.arviz_bridge import Draws
from bayescal.inference.sampled_model import SampledModel
from bayescal.inference.stored import pack_sampled, pack_weighted, unpack_weighted
from bayescal.inference.weighting import WeightedDraws
from bayescal.points.setup import AXES
from bayescal.report.agreement import NATS, alike
from bayescal.report.families_document import SCHEMA, families_document
from bayescal.report.run import fill_run
from bayescal.report.run_files import RunFiles
from bayescal.report.shape import COEFFICIENT, NUMBER, Maybe

MODEL = {
    "name": str,
    "log_evidence": NUMBER,
    "log_evidence_error": NUMBER,
    "log_likelihood_max": NUMBER,
    "probability": NUMBER,
    "elpd_loo": NUMBER,
    "sampling": Maybe({"parameters": [COEFFICIENT]}),
}
DOCUMENT = {
    "provenance": {"command": str, "seed": int},
    "data": {"source": str, "sha256": str},
    "settings": {
        "families": [str],
        "orders": [int],
        "positions": (list, type(None)),
        "radial": str,
        "radial_orders": [int],
        "pairs": (list, type(None)),
        "sigma": (*NUMBER, str),
        "prior": (str, type(None)),
        "tau": NUMBER,
        "noise": str,
        "nu": NUMBER,
        "bad_offset": bool,
        "seed": int,
        "ess": int,
    },
    "families": {"models": [MODEL]},
    "verdict": {"best": str, "plausible": [str], "decided": bool},
}
# Draws are kept in coordinates about a maximum that is searched for again. Another machine's
# rounding ends the search elsewhere: by 1e-6 nat of leave-one-out on the thesis's points.
SEARCHED = 1e-4
ASKED = frozenset(field.name for field in dataclasses.fields(FamilyRequest))


def write_families(folder: Path, found: FamilyComparison, result_json: str, *, force: bool) -> None:
    """Write a comparison across families as a run, whole or not at all.

    Parameters
    ----------
    folder : Path
    found : FamilyComparison
    result_json : str
        The result document.
    force : bool
        Replace an earlier run.

    Raises
    ------
    OutputError
        Where it can't be written; nothing is left behind.
    """
    draws = {}
    for model in found.models:
        if model.posterior is not None:
            draws[model.name.key] = _described(pack_sampled(model.posterior), found, model)
        elif model.weighted is not None:
            draws[model.name.key] = _described(pack_weighted(model.weighted), found, model)
    fill_run(folder, found.points, result_json, draws, force=force)


def _described(draws: Draws, found: FamilyComparison, model: JointModel) -> Draws:
    """Add to draws what a reader who knows nothing of bayescal needs."""
    observed: dict[str, Array] = {axis: found.points.pixel(axis) for axis in AXES}
    draws.groups["observed_data"] = observed
    draws.described.update(
        {
            "model": str(model.name),
            "units": "focal, centre, sigma, coefficients px; rotation degrees; position world "
            "units; tau a fraction of the image; scale a factor",
            "inference_library": "emcee" if model.posterior is not None else "bayescal",
        }
    )
    return draws


def open_families(folder: str | Path) -> FamilyComparison:
    """Read a comparison across families back from the folder that `write_families` wrote.

    Nothing is sampled or weighed anew: draws and weights are read. The rest is computed again,
    from them, the points or the closed form, and compared with what the run says; evidences
    without a point, which leave-one-out may need, from the same random numbers.

    Parameters
    ----------
    folder : str or Path

    Returns
    -------
    FamilyComparison

    Raises
    ------
    InputError
        As `bayescal.open_run`.
    """
    run = _Run.at(Path(folder))
    settings, points = run.settings(ASKED), run.points()
    try:
        found = compare_joint(points, run.request, settings, None, run)
    except InputError as error:
        raise error if str(error).startswith(str(run.folder)) else run.unusable(error) from None
    wrong = _disagreement(run.document, families_document(found, ""))
    if wrong is not None:
        raise InputError(f"{run.folder}: {wrong}: {run.between()}; {run.again}")
    return dataclasses.replace(found, origin=run.document["provenance"])


@dataclass(frozen=True, eq=False)
class _Run(RunFiles):
    """The run of a comparison across families."""

    schema = SCHEMA
    made_by = "compare --family"
    shape = DOCUMENT
    axis_shape = None

    @property
    def request(self) -> FamilyRequest:
        """Which models were asked for."""
        stated = self.document["settings"]
        try:
            asked = {name: _frozen(stated[name]) for name in ASKED}
            if asked["pairs"] is not None:
                asked["pairs"] = tuple((int(k), int(m)) for k, m in asked["pairs"])
            return FamilyRequest(**asked)
        except (TypeError, ValueError) as error:
            raise self.unusable(error) from None

    def weighted(
        self,
        name: str,
        model: SampledModel,
        compute: Callable[[], WeightedDraws],  # noqa: ARG002 - nothing is drawn
    ) -> WeightedDraws:
        """Read the weighted draws of a model that was not sampled."""
        return self.read_draws(name, lambda draws: unpack_weighted(draws, model))


def _frozen(value: Any) -> Any:
    """Make tuples of lists, inside too."""
    return tuple(map(_frozen, value)) if isinstance(value, list) else value


def _disagreement(kept: dict[str, Any], made: dict[str, Any]) -> str | None:
    """Name the first number that the run and the computation just made don't share."""
    models = {m["name"]: m for m in made["families"]["models"]}
    was = [m["name"] for m in kept["families"]["models"]]
    if sorted(was) != sorted(models):
        odd = sorted(set(was) ^ set(models)) or ["a model named twice"]
        return f"the run and what it asks for don't have the same models: {odd[0]}"
    for old in kept["families"]["models"]:
        wrong = _other_numbers(old, models[old["name"]])
        if wrong is not None:
            return wrong
    for key in ("best", "plausible", "decided"):
        if kept["verdict"][key] != made["verdict"][key]:
            was_said, now = kept["verdict"][key], made["verdict"][key]
            return f"verdict: {key} is {was_said} in the run but {now} now"
    return None


def _other_numbers(old: dict[str, Any], new: dict[str, Any]) -> str | None:
    """Name the first number of a model that differs."""
    for key, words in (
        ("log_evidence", "log evidence"),
        ("log_likelihood_max", "maximum of the log likelihood"),
        ("probability", "probability"),
        ("elpd_loo", "leave-one-out elpd"),
    ):
        was, now = old[key], new[key]
        near = key == "elpd_loo" and None not in (was, now) and abs(was - now) < SEARCHED
        if not (near or alike(was, now)):
            return f"the {words} of {old['name']} is {was} in the run but {now} now"
    if old["sampling"] is None or new["sampling"] is None:
        return None if old["sampling"] is new["sampling"] else f"{old['name']} was not sampled"
    said, drawn = (found["sampling"]["parameters"] for found in (old, new))
    if [p["name"] for p in said] != [p["name"] for p in drawn]:
        return f"the parameters of {old['name']} are not those of its draws"
    for one, other in zip(said, drawn, strict=True):
        if abs(one["mean"] - other["mean"]) > NATS * other["sd"]:
            return (
                f"the mean of {one['name']} of {old['name']} is {one['mean']} in the run but "
                f"{other['mean']} from its draws"
            )
    return None
