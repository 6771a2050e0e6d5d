"""A comparison of lens models over many views as a kind of result."""

from __future__ import annotations

import dataclasses
from typing import Any

from threadpoolctl import threadpool_limits

from bayescal.calibration.judge import Setting
from bayescal.calibration.observations import Observations
from bayescal.calibration.sampled import SampledLens
from bayescal.comparison.convert import Converts
from bayescal.comparison.lenses.analysis import concluded, level_of
from bayescal.comparison.lenses.gross_errors import gross_errors
from bayescal.comparison.lenses.request import LensRequest
from bayescal.comparison.lenses.results import Drawn, LensComparison
from bayescal.comparison.lenses.sweep import image_size
from bayescal.comparison.settings import Settings
from bayescal.errors import InputError
from bayescal.inference.arviz_bridge import Draws
from bayescal.inference.stored import packed, unpack_sampled
from bayescal.points.views.views import Views
from bayescal.points.views.writer import views_to_csv
from bayescal.report.document.lenses import SCHEMA, lenses_document
from bayescal.report.run.files import RunFiles
from bayescal.report.run.folder import LENSES, VIEWS, described
from bayescal.report.run.kept_lenses import KeptLenses, lenses_bytes
from bayescal.report.run.kind import RunKind
from bayescal.report.run.shape import NUMBER, Same
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
        """Give its views, and what takes long about its lenses."""
        return {VIEWS: views_to_csv(result.views).encode(), LENSES: lenses_bytes(result)}

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

    def reopen(self, run: RunFiles, settings: Settings) -> LensComparison:
        """Conclude again from what was judged and drawn."""
        asked = run.document["settings"]
        request = LensRequest(**{name: asked[name] for name in ASKED & set(asked)})
        if request.lenses is not None:
            request = dataclasses.replace(request, lenses=tuple(request.lenses))
        seen = run.views()
        try:
            kept = KeptLenses(run.content(LENSES))
            data = Observations.from_views(seen, image_size(seen))
            if kept.levels is not None:
                data = data.with_levels(kept.levels)
            level = level_of(settings)
            setting = Setting.of(data, level, independent=request.independent)
            lenses = kept.lenses(setting, request)
            best = lenses[0]
            model = SampledLens(best.evidence.density)
            posterior = run.read_draws(best.key.file(), lambda d: unpack_sampled(d, model))
            drawn = Drawn(posterior, kept.draws, kept.covariance, kept.halves)
            gross = kept.gross
            impossible, failures = kept.names("impossible"), kept.names("failures")
        except (ValueError, KeyError, TypeError, IndexError) as error:
            raise InputError(
                f"{run.folder / LENSES}: is damaged: {' '.join(str(error).split())}; {run.again}"
            ) from None
        with threadpool_limits(1):
            return concluded(
                seen,
                request,
                settings,
                setting,
                lenses,
                drawn,
                gross_errors(lenses, setting, seen) if gross is None else gross,
                impossible=impossible,
                failures=failures,
            )


KIND = LensesKind()
