"""A comparison across families as a kind of result."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

from bayescal.comparison.faces.convert import kept_groups
from bayescal.comparison.families.analysis import compare_joint
from bayescal.comparison.families.request import FamilyRequest
from bayescal.comparison.families.result import JointModel
from bayescal.comparison.families.results import FamilyComparison
from bayescal.comparison.settings import Settings
from bayescal.inference.arviz_bridge import Draws
from bayescal.inference.stored import packed
from bayescal.prediction.calibrated.camera import CalibratedCamera
from bayescal.prediction.calibrated.families import families_camera
from bayescal.report.document.families import SCHEMA, families_document
from bayescal.report.kinds.comparison import COEFFICIENT, EVIDENCE, SETTINGS
from bayescal.report.run.files import RunFiles
from bayescal.report.run.folder import described
from bayescal.report.run.kind import RunKind
from bayescal.report.run.reduction import REDUCTION, reduction_bytes
from bayescal.report.run.shape import NUMBER, Maybe, Same
from bayescal.report.run.store import StoredDraws
from bayescal.report.views.families.views import VIEWS

# Draws are kept in coordinates about a maximum that is searched for again. Another machine's
# rounding ends the search elsewhere: by 1e-6 nat of leave-one-out on the thesis's points.
SEARCHED = 1e-4
MODEL = {
    "name": str,
    **EVIDENCE,
    "log_evidence_error": NUMBER,
    "elpd_loo": Same("leave-one-out elpd", within=SEARCHED),
    "sampling": Maybe({"parameters": [COEFFICIENT]}),
}
SHAPE = {
    "provenance": {"command": str, "seed": int},
    "data": {"source": str, "sha256": str},
    "settings": {
        "families": [str],
        "orders": [int],
        "positions": (list, type(None)),
        "radial": str,
        "radial_orders": [int],
        "pairs": (list, type(None)),
        **SETTINGS,
        "noise": str,
        "nu": NUMBER,
        "bad_offset": bool,
    },
    "families": {"models": [MODEL]},
    "verdict": {
        "best": Same("best model", str),
        "plausible": Same("list of plausible models", list),
        "decided": Same("verdict's decided", bool),
    },
}
ASKED = frozenset(field.name for field in dataclasses.fields(FamilyRequest))


class FamiliesKind(RunKind[FamilyComparison]):
    """A comparison of joint models of r and c."""

    result = FamilyComparison
    name = "families"
    element = "families"
    views = VIEWS
    schema = SCHEMA
    made_by = "compare --family"
    shape = SHAPE
    beside = ASKED
    defended = True

    def document(self, result: FamilyComparison, command: str) -> dict[str, Any]:
        """Build its document."""
        return families_document(result, command)

    def checked(self, result: FamilyComparison) -> dict[str, Any]:
        """Build its document without closed forms' parameters."""
        return families_document(result, "", whole=False)

    def models(self, result: FamilyComparison) -> dict[str, JointModel]:
        """Every model compared."""
        return {model.key.file(result.settings.noise): model for model in result.models}

    def draws(self, result: FamilyComparison) -> dict[str, Draws]:
        """Draws of the models that were sampled, weighted ones of those that were weighted."""
        found = {}
        for name, model in self.models(result).items():
            kept = model.posterior or model.weighted
            if kept is None:
                continue
            found[name] = described(
                packed(kept),
                kept_groups(model.held()),
                model=str(model.key),
                units="focal, centre, sigma, coefficients px; rotation degrees; position world "
                "units; tau a fraction of the image; scale a factor",
                library="bayescal" if model.posterior is None else "emcee",
            )
        return found

    def camera(self, result: FamilyComparison) -> CalibratedCamera:
        """Make its camera."""
        return families_camera(result)

    def files(self, result: FamilyComparison) -> dict[str, bytes]:
        """Give the reduction of many points too."""
        found = super().files(result)
        return {**found, REDUCTION: reduction_bytes(result.whole)} if result.whole else found

    def reopen(self, run: RunFiles, settings: Settings) -> FamilyComparison:
        """Compare again, with the run's draws and weights.

        Evidences without a point, which leave-one-out may need, come from the same random numbers.
        """
        request = _request(run.document["settings"], run)
        store = StoredDraws(run, settings.noise)
        return compare_joint(run.points(), request, settings, store=store, whole=run.whole())


KIND = FamiliesKind()


def _request(stated: Mapping[str, Any], run: RunFiles) -> FamilyRequest:
    """Which models were asked for."""
    try:
        asked = {name: _frozen(stated[name]) for name in ASKED}
        if asked["pairs"] is not None:
            asked["pairs"] = tuple((int(k), int(m)) for k, m in asked["pairs"])
        return FamilyRequest(**asked)
    except (TypeError, ValueError) as error:
        raise run.unusable(error) from None


def _frozen(value: Any) -> Any:
    """Make tuples of lists, inside too."""
    return tuple(map(_frozen, value)) if isinstance(value, list) else value
