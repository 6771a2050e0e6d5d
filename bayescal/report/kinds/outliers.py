"""An analysis of bad points as a kind of result."""

from __future__ import annotations

from typing import Any

from bayescal.comparison.orders.result import OrderResult
from bayescal.comparison.outliers.analysis import find_outliers
from bayescal.comparison.outliers.rejection import RejectionRule
from bayescal.comparison.outliers.request import OutlierRequest
from bayescal.comparison.outliers.results import OutlierStudy
from bayescal.comparison.settings import Settings
from bayescal.inference.arviz_bridge import Draws
from bayescal.noise.outlier_mixture import OutlierMixture
from bayescal.noise.student_t import StudentT
from bayescal.points.setup import AXES
from bayescal.report.document.outliers import SCHEMA, outliers_document
from bayescal.report.kinds.comparison import SETTINGS, axes_draws
from bayescal.report.run.files import RunFiles
from bayescal.report.run.kind import RunKind
from bayescal.report.run.shape import NUMBER, Each, Same
from bayescal.report.run.store import StoredDraws
from bayescal.report.views.outliers.views import VIEWS

NOW = "from its draws"
SHAPE = {
    "provenance": {"command": str, "seed": int},
    "data": {"source": str, "sha256": str},
    "significance": (int, float),
    "settings": {**SETTINGS, "nu": NUMBER, "bad_offset": bool},
    "axes": Each(
        {
            "order": int,
            "points": [
                {
                    "label": str,
                    "bad_probability": Same("probability of being bad", now=NOW),
                    "weight": Same("weight", now=NOW),
                }
            ],
            "treatments": [
                {"name": str, "log_evidence": Each(Same("log evidence"), named="order")}
            ],
        },
        keys=AXES,
    ),
}


class OutliersKind(RunKind[OutlierStudy]):
    """Which points are bad, and whether the choice of the order depends on them."""

    result = OutlierStudy
    name = "outliers"
    element = "outliers"
    views = VIEWS
    schema = SCHEMA
    made_by = "outliers"
    shape = SHAPE
    beside = frozenset({"nu", "bad_offset"})  # of both noise models, not of the one compared

    def document(self, result: OutlierStudy, command: str) -> dict[str, Any]:
        """Build its document."""
        return outliers_document(result, command)

    def models(self, result: OutlierStudy) -> dict[str, OrderResult]:
        """Every order under every noise model that is sampled."""
        return {
            judged.key.file(): judged
            for axis in result.axes.values()
            for treatment in axis.treatments
            for judged in treatment.sampled
        }

    def draws(self, result: OutlierStudy) -> dict[str, Draws]:
        """Draws of them."""
        return axes_draws(self.models(result))

    def reopen(self, run: RunFiles, settings: Settings) -> OutlierStudy:
        """Look again, with the run's draws."""
        asked, axes = run.document["settings"], run.document["axes"]
        first = next(iter(axes.values()))
        request = OutlierRequest(
            tuple(axes),
            tuple(int(k) for k in first["treatments"][0]["log_evidence"]),
            (StudentT(asked["nu"]), OutlierMixture(infers_offset=asked["bad_offset"])),
            RejectionRule(run.document["significance"]),
        )
        return find_outliers(run.points(), request, settings, store=StoredDraws(run))


KIND = OutliersKind()
