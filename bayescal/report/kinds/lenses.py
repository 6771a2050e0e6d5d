"""A comparison of lens models over many views as a kind of result."""

from __future__ import annotations

import dataclasses
from typing import Any

from bayescal.comparison.faces.convert import Converts
from bayescal.comparison.lenses.analysis import compare_lenses
from bayescal.comparison.lenses.request import LensRequest
from bayescal.comparison.lenses.results import LensComparison
from bayescal.comparison.settings import Settings
from bayescal.inference.arviz_bridge import Draws
from bayescal.inference.stored import packed
from bayescal.points.views.views import Views
from bayescal.points.views.writer import views_to_csv
from bayescal.prediction.calibrated.camera import CalibratedCamera
from bayescal.prediction.calibrated.lenses import lens_camera
from bayescal.report.document.lenses import SCHEMA, lenses_document
from bayescal.report.run.files import RunFiles
from bayescal.report.run.folder import VIEWS, described
from bayescal.report.run.kind import RunKind
from bayescal.report.run.shape import NUMBER, Same
from bayescal.report.run.store import StoredDraws
from bayescal.report.views.lenses.views import VIEWS as SHOWN

# Residuals are computed again at the lens and poses that were kept; another machine rounds the
# determinants of their normal equations otherwise.
ROUNDED = 1e-4
SHAPE = {
    "provenance": {"command": str, "seed": int},
    "data": {"source": str, "sha256": str, "n_points": Same("number of points", int)},
    "settings": {
        "lenses": (list, type(None)),
        "independent": bool,
        "square": bool,
        "centred": bool,
        "draws": int,
        "sigma": (*NUMBER, str),
        "seed": int,
        "ess": int,
    },
    "lenses": [
        {
            "name": str,
            "log_evidence": Same("log evidence"),
            "probability": Same("probability"),
            "rms_px": Same("RMS"),
            "difference_inside_px": Same("difference to the best", within=ROUNDED),
        }
    ],
    "posterior": {
        "lens": Same("best lens", str),
        "log_evidence_laplace": Same("log evidence by linear algebra", within=ROUNDED),
    },
    "verdict": {
        "best": Same("best lens", str),
        "plausible": Same("list of plausible lenses", list),
        "status": Same("verdict's status", str),
    },
}
ASKED = frozenset(field.name for field in dataclasses.fields(LensRequest))


class LensesKind(RunKind[LensComparison]):
    """Which lens model many views support."""

    result = LensComparison
    name = "lenses"
    element = "lenses"
    views = SHOWN
    schema = SCHEMA
    made_by = "calibrate"
    shape = SHAPE
    beside = ASKED

    def document(self, result: LensComparison, command: str) -> dict[str, Any]:
        """Build its document."""
        return lenses_document(result, command)

    def checked(self, result: LensComparison) -> dict[str, Any]:
        """Build its document without covariances."""
        return lenses_document(result, "", whole=False)

    def read(self, result: LensComparison) -> Views:
        """Give its views."""
        return result.views

    def files(self, result: LensComparison) -> dict[str, bytes]:
        """Give its views."""
        return {VIEWS: views_to_csv(result.views).encode()}

    def models(self, result: LensComparison) -> dict[str, Converts]:
        """Every lens compared; the best one's draws."""
        others: dict[str, Converts] = {judged.key.file(): judged for judged in result.lenses}
        return {**others, result.best.key.file(): result}

    def draws(self, result: LensComparison) -> dict[str, Draws]:
        """Draws of the best lens, under its most probable error model."""
        best, pixels = result.best, result.views.pixels
        kept = described(
            packed(result.posterior),
            {"observed_data": {"r": pixels[:, 0], "c": pixels[:, 1]}},
            lens=best.name,
            units="fx, fy, cx, cy, sigma px; coefficients without unit; bow in the target's unit; "
            "tau a fraction of the image's width, of bow of the target's diagonal",
        )
        return {best.key.file(): kept}

    def camera(self, result: LensComparison) -> CalibratedCamera:
        """Make its camera."""
        return lens_camera(result)

    def reopen(self, run: RunFiles, settings: Settings) -> LensComparison:
        """Compare again, with what was judged and drawn."""
        asked = run.document["settings"]
        request = LensRequest(**{name: asked[name] for name in ASKED & set(asked)})
        if request.lenses is not None:
            request = dataclasses.replace(request, lenses=tuple(request.lenses))
        return compare_lenses(run.views(), request, settings, store=StoredDraws(run))


KIND = LensesKind()
