"""A comparison of orders as a kind of result."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from bayescal.comparison.analysis import analyse_points
from bayescal.comparison.defence.stability import Beyond
from bayescal.comparison.judged import Judged
from bayescal.comparison.results import Comparison
from bayescal.comparison.settings import Settings
from bayescal.errors import InputError
from bayescal.inference.arviz_bridge import Draws
from bayescal.inference.posterior import Posterior
from bayescal.inference.stored import packed
from bayescal.points.setup import AXES
from bayescal.polynomials import separable
from bayescal.polynomials.axis_data import AxisData
from bayescal.report.document.comparison import SCHEMA, comparison_document
from bayescal.report.document.defence import noises_from
from bayescal.report.run.files import RunFiles
from bayescal.report.run.folder import described
from bayescal.report.run.kind import RunKind
from bayescal.report.run.shape import NUMBER, Each, Same
from bayescal.report.run.store import StoredDraws, with_left_out
from bayescal.version import __version__

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
    schema = SCHEMA
    made_by = "compare"
    shape = SHAPE
    defended = True

    def document(self, result: Comparison, command: str) -> dict[str, Any]:
        """Build its document."""
        return comparison_document(result, command)

    def draws(self, result: Comparison) -> dict[str, Draws]:
        """Draws of every order of every axis."""
        kept = {}
        for axis in result.axes.values():
            for found in axis.orders:
                draws = axis_draws(found.posterior, axis.data, found.order)
                if axis.defence is not None and found.order in axis.defence.prediction:
                    with_left_out(draws, axis.defence.prediction[found.order].psis)
                kept[found.key.file(axis.noise_model.name)] = draws
        return kept

    def pictures(self, folder: Path, result: Comparison) -> None:
        """Draw each axis's corner plot."""
        from bayescal.report.figures.registry import KINDS
        from bayescal.report.figures.style import figure_bytes

        for name in result.axes:
            figure = KINDS["corner"].draw(result, name)
            (folder / f"corner-{name}.png").write_bytes(figure_bytes(figure, "png", dpi=150))

    def reopen(self, run: RunFiles, settings: Settings) -> Comparison:
        """Compare again, with the run's draws; the look at other families is the run's own."""
        family, axes = run.document["family"], run.document["axes"]
        if family != separable.NAME:
            raise InputError(
                f"{run.folder}: is of the family {family!r}, which bayescal "
                f"{__version__} does not have ({run.between()}); upgrade bayescal"
            )
        orders = {name: tuple(o["order"] for o in axis["orders"]) for name, axis in axes.items()}
        found = analyse_points(run.points(), orders, settings, None, _Stored(run, settings.noise))
        return found.with_hint(run.document.get("families", {}).get("hint"))


COMPARISON = ComparisonKind()


def axis_draws(posterior: Posterior, data: AxisData, order: int) -> Draws:
    """Arrange the draws of one order of an axis for those who know nothing of bayescal."""
    return described(
        packed(posterior),
        {"pixel": data.t, "regressor": data.x},
        axis=data.axis,
        regressor=data.regressor,
        order=order,
        units="coefficients and sigma in px, tau a fraction of the image, scale a factor",
    )


class _Stored(StoredDraws):
    """What a comparison's run keeps beside draws: numbers of its defence that take long."""

    def noises(self, axis: str) -> tuple[Judged, ...] | None:
        """Evidence under other noise models, where the run's defence has it."""
        defence = self._defence(axis)
        return None if defence is None else noises_from(defence["noises"], axis)

    def wins(self, axis: str, unit: str) -> dict[int, float] | None:
        """Bootstrap shares of an axis, which take most of a defence's time."""
        defence = self._defence(axis)
        for found in defence["bootstrap"] if defence is not None else []:
            if found["unit"] == unit:
                return {int(k): share for k, share in found["share"].items()}
        return None

    def beyond(self, axis: str, highest: int) -> Beyond | None:
        """Orders above the compared range, which without a closed form are sampled."""
        found = None if (defence := self._defence(axis)) is None else defence["beyond"]
        if found is None:
            return None
        chances = {int(k): p for k, p in found["probability"].items()}
        return Beyond(chances, found["winner"], tuple(k for k in chances if k > highest))

    def _defence(self, axis: str) -> dict[str, Any] | None:
        found: dict[str, Any] | None = self.run.document["axes"][axis]["defence"]
        return found
