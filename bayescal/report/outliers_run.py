"""An analysis of bad points as a run: written, and reopened without sampling."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from pathlib import Path

from bayescal.comparison.defence.noise_evidence import model_name
from bayescal.comparison.outliers.analysis import find_outliers
from bayescal.comparison.outliers.rejection import RejectionRule
from bayescal.comparison.outliers.results import OutlierStudy
from bayescal.comparison.settings import Settings
from bayescal.errors import InputError
from bayescal.inference.stored import pack_sampled
from bayescal.noise.outlier_mixture import OutlierMixture
from bayescal.noise.student_t import StudentT
from bayescal.report.agreement import alike
from bayescal.report.outliers import SCHEMA, outliers_document
from bayescal.report.run import described, fill_run
from bayescal.report.run_files import RunFiles
from bayescal.report.shape import NUMBER

DOCUMENT = {
    "provenance": {"command": str, "seed": int},
    "data": {"source": str, "sha256": str},
    "significance": (int, float),
    "settings": {
        "sigma": (*NUMBER, str),
        "prior": (str, type(None)),
        "tau": NUMBER,
        "seed": int,
        "ess": int,
        "nu": NUMBER,
        "bad_offset": bool,
    },
    "axes": dict,
}
AXIS = {
    "order": int,
    "points": [{"label": str, "bad_probability": NUMBER, "weight": NUMBER}],
    "treatments": [{"name": str, "log_evidence": dict}],
}


def write_outliers(folder: Path, study: OutlierStudy, result_json: str, *, force: bool) -> None:
    """Write an analysis of bad points as a run, whole or not at all.

    Parameters
    ----------
    folder : Path
    study : OutlierStudy
    result_json : str
        The result document.
    force : bool
        Replace an earlier run.

    Raises
    ------
    OutputError
        Where it can't be written; nothing is left behind.
    """
    draws = {
        model_name(axis.data.axis, treatment.evidence.name, order): described(
            pack_sampled(posterior), axis.data, order
        )
        for axis in study.axes.values()
        for treatment in axis.treatments
        for order, posterior in treatment.evidence.posteriors.items()
    }
    fill_run(folder, study.points, result_json, draws, force=force)


def open_outliers(folder: str | Path) -> OutlierStudy:
    """Read an analysis of bad points back from the folder that ``outliers --out`` wrote.

    Nothing is sampled: the draws are read; the rest is computed again and compared with what
    the run says.

    Parameters
    ----------
    folder : str or Path

    Returns
    -------
    OutlierStudy

    Raises
    ------
    InputError
        As `bayescal.open_run`.
    """
    run = _Run.at(Path(folder))
    asked, axes = run.document["settings"], run.document["axes"]
    try:
        settings = Settings(*(asked[name] for name in ("sigma", "prior", "tau", "seed", "ess")))
        noises = StudentT(asked["nu"]), OutlierMixture(infers_offset=asked["bad_offset"])
        rule = RejectionRule(run.document["significance"])
        first = next(iter(axes.values()))
        orders = tuple(int(k) for k in first["treatments"][0]["log_evidence"])
    except (InputError, ValueError) as error:
        raise run.unusable(error) from None
    study = find_outliers(
        run.points(), list(axes), orders, settings, noises, rule, lambda _: None, run.sampled
    )
    wrong = _disagreement(run, study)
    if wrong is not None:
        raise InputError(f"{run.folder}: {wrong}: {run.between()}; {run.again}")
    return dataclasses.replace(study, origin=run.document["provenance"])


@dataclass(frozen=True, eq=False)
class _Run(RunFiles):
    """The run of an analysis of bad points."""

    schema = SCHEMA
    made_by = "outliers"
    shape = DOCUMENT
    axis_shape = AXIS


def _disagreement(run: RunFiles, study: OutlierStudy) -> str | None:
    """Name the first number that the run and the computation just made don't share."""
    now = outliers_document(study, "")["axes"]
    for name, was in run.document["axes"].items():
        for old, new in zip(was["treatments"], now[name]["treatments"], strict=True):
            for order, value in old["log_evidence"].items():
                made = new["log_evidence"].get(order)
                if not alike(value, made):
                    return (
                        f"the log evidence of {name}, order {order} under {old['name']} is {value} "
                        f"in the run but {made} now"
                    )
        for old, new in zip(was["points"], now[name]["points"], strict=True):
            if old["label"] != new["label"]:
                return f"point {old['label']} of {name} stands where {new['label']} does now"
            for key in ("bad_probability", "weight"):
                if not alike(old[key], new[key]):
                    return (
                        f"{key} of point {old['label']} of {name} is {old[key]} in the run but "
                        f"{new[key]} from its draws"
                    )
    return None
