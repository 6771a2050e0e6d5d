"""A comparison of orders as a kind of result."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bayescal.comparison.analysis import analyse_points
from bayescal.comparison.results import Comparison, OrderResult
from bayescal.comparison.settings import Settings
from bayescal.errors import InputError
from bayescal.inference.arviz_bridge import Draws
from bayescal.points.setup import AXES
from bayescal.polynomials import separable
from bayescal.report.document.comparison import SCHEMA, comparison_document
from bayescal.report.run.files import RunFiles
from bayescal.report.run.folder import described
from bayescal.report.run.kind import RunKind
from bayescal.report.run.reduction import REDUCTION, reduction_bytes
from bayescal.report.run.shape import NUMBER, Each, Same
from bayescal.report.views.comparison import VIEWS
from bayescal.version import __version__

if TYPE_CHECKING:  # what is printed alone does not pay for a camera
    from bayescal.prediction.calibrated.camera import CalibratedCamera

MEAN = Same("mean", unit="sd", now="from its draws")
COEFFICIENT = {"name": str, "mean": MEAN, "sd": NUMBER}
EVIDENCE = {
    "log_evidence": Same("log evidence"),
    "log_likelihood_max": Same("maximum of the log likelihood"),
    "probability": Same("probability"),
}
SETTINGS = {
    "sigma": (*NUMBER, str),
    "prior": (str, type(None)),
    "tau": NUMBER,
    "seed": int,
    "ess": int,
}
SHAPE = {
    "family": str,
    "provenance": {"command": str},
    "settings": {**SETTINGS, "defend": bool},
    "data": {"source": str, "sha256": str},
    "axes": Each(
        {
            "orders": [{"order": int, **EVIDENCE, "coefficients": [COEFFICIENT]}],
            "verdict": {"order": Same("recommended order")},
            "defence": (dict, type(None)),
        },
        keys=AXES,
    ),
}


class ComparisonKind(RunKind[Comparison]):
    """A comparison of orders, axis by axis."""

    result = Comparison
    name = "comparison"
    element = "result"
    views = VIEWS
    schema = SCHEMA
    made_by = "compare"
    shape = SHAPE
    defended = True

    def document(self, result: Comparison, command: str) -> dict[str, Any]:
        """Build its document."""
        return comparison_document(result, command)

    def models(self, result: Comparison) -> dict[str, OrderResult]:
        """Every order of every axis."""
        noise = result.settings.noise
        return {found.key.file(noise): found for axis in result for found in axis}

    def draws(self, result: Comparison) -> dict[str, Draws]:
        """Draws of every order of every axis."""
        return axes_draws(self.models(result))

    def files(self, result: Comparison) -> dict[str, bytes]:
        """Give the reduction of many points too."""
        whole = {name: axis.data.whole for name, axis in result.axes.items() if axis.data.whole}
        found = super().files(result)
        return {**found, REDUCTION: reduction_bytes(whole)} if whole else found

    def pictures(self, folder: Path, result: Comparison) -> None:
        """Draw each axis's corner plot."""
        from bayescal.report.figures.registry import KINDS
        from bayescal.report.figures.style import figure_bytes

        for name in result.axes:
            figure = KINDS["corner"].draw(result, name)
            (folder / f"corner-{name}.png").write_bytes(figure_bytes(figure, "png", dpi=150))

    def camera(self, result: Comparison) -> CalibratedCamera:
        """Make its camera."""
        from bayescal.prediction.calibrated.orders import orders_camera

        return orders_camera(result)

    def reopen(self, run: RunFiles, settings: Settings) -> Comparison:
        """Compare again, with the run's draws; the look at other families is the run's own."""
        family, axes = run.document["family"], run.document["axes"]
        if family != separable.NAME:
            raise InputError(
                f"{run.folder}: is of the family {family!r}, which bayescal "
                f"{__version__} does not have ({run.between()}); upgrade bayescal"
            )
        orders = {name: tuple(o["order"] for o in axis["orders"]) for name, axis in axes.items()}
        from bayescal.report.run.store import StoredDraws

        store = StoredDraws(run, settings.noise)
        found = analyse_points(run.points(), orders, settings, None, store, run.whole())
        return found.with_hint(run.document.get("families", {}).get("hint"))


KIND = ComparisonKind()


def axes_draws(models: Mapping[str, OrderResult]) -> dict[str, Draws]:
    """Arrange the draws of orders of axes for those who know nothing of bayescal."""
    from bayescal.comparison.faces.convert import kept_groups, order_held
    from bayescal.inference.stored import packed

    found = {}
    for name, one in models.items():
        data, groups = one.data, kept_groups(order_held(one.posterior, one.data))
        groups["observed_data"] = {"pixel": data.t, "regressor": data.x}
        found[name] = described(
            packed(one.posterior),
            groups,
            axis=data.axis,
            regressor=data.regressor,
            order=one.order,
            units="coefficients and sigma in px, tau a fraction of the image, scale a factor",
        )
    return found
