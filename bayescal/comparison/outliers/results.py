"""What an analysis of bad points found: small frozen values, and what they say in words."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from bayescal.comparison.faces.face import ByAxis, Lists, Recommends
from bayescal.comparison.faces.frames import bad_points_frame, treatments_frame
from bayescal.comparison.finding import Finding
from bayescal.comparison.orders.result import OrderResult
from bayescal.comparison.outliers.records import Elimination, PointRecord
from bayescal.comparison.outliers.shared_errors import SharedError
from bayescal.comparison.outliers.treatments import Treatment, verdict_words
from bayescal.markup import bullets, paragraph, table
from bayescal.noise.level import NoiseLevel
from bayescal.noise.outlier_mixture import OutlierMixture
from bayescal.noise.student_t import StudentT
from bayescal.points.correspondences import Correspondences
from bayescal.polynomials.axis_data import AxisData
from bayescal.prior.amplitudes import PriorRule
from bayescal.rounding import percent, rounded, significant

if TYPE_CHECKING:
    import pandas as pd

    from bayescal.comparison.settings import Settings


@dataclass(frozen=True, eq=False)
class AxisOutliers(Recommends, Lists[str, PointRecord]):
    """Bad points of one axis, and what they do to the choice of the order.

    Attributes
    ----------
    noise_source : str
        How the noise level was chosen, in words.
    order : int
        Whose residuals and predictions are shown: the most probable one under the noise
        model of the largest evidence.
    points : tuple of PointRecord
        The most suspicious first.
    elimination : Elimination
        By the chi-squared test, at every order.
    treatments : tuple of Treatment
        Gaussian noise with all points and without those eliminated, Student-t, mixture.
    shared : tuple of SharedError
        Bad points that share world coordinates with others.
    findings : tuple of Finding
        What says that the model itself is not the right one, under Gaussian noise.
    """

    data: AxisData
    level: NoiseLevel
    prior: PriorRule
    noise_source: str
    order: int
    points: tuple[PointRecord, ...]
    elimination: Elimination
    treatments: tuple[Treatment, ...]
    shared: tuple[SharedError, ...]
    findings: tuple[Finding, ...] = ()

    absent = "there is no point {0!r}"

    def named(self) -> list[tuple[str, PointRecord]]:
        """List the points by their labels."""
        return [(point.label, point) for point in self.points]

    def to_dataframe(self) -> pd.DataFrame:
        """Points in a data frame of pandas, a row each, the worst first."""
        return bad_points_frame([self])

    @property
    def chosen(self) -> OrderResult:
        """The order shown under the outlier mixture, whose posterior is handed on."""
        return next(found for found in self.treatments[-1].sampled if found.order == self.order)

    @property
    def bad(self) -> tuple[PointRecord, ...]:
        """Points that are more probably bad than good, the worst first."""
        return tuple(p for p in self.points if p.bad)

    @property
    def suspicious(self) -> tuple[PointRecord, ...]:
        """Bad points, and those that the chi-squared test removes at the order shown."""
        return tuple(p for p in self.points if p.bad or self.order in p.rejected_at)

    @property
    def sound(self) -> bool:
        """Whether every evidence can be trusted and every chain converged."""
        return all(judged.sound for t in self.treatments for judged in t.orders)

    @property
    def against_the_model(self) -> tuple[str, ...]:
        """What says that the model is not the right one: to be looked at before any point."""
        return tuple(f.text for f in self.findings if f.withholds)

    @property
    def caveats(self) -> tuple[str, ...]:
        """What else limits what is said of points and orders."""
        return tuple(f.text for f in self.findings if not f.withholds)

    @property
    def explanations(self) -> tuple[str, ...]:
        """A sentence for each suspicious point, or for those that share an error."""
        together = [s for s in self.shared if s.together]
        told = {label for s in together for label in s.points}
        alone = [self._alone(p) for p in self.suspicious if p.label not in told]
        return (*(s.words for s in together), *alone)

    def _alone(self, point: PointRecord) -> str:
        predicted = rounded(point.predicted, point.predicted_sd)
        line = (
            f"point {point.label}: {self.data.axis} = {point.measured:g} where the mixture "
            f"predicts {predicted} ± {significant(point.predicted_sd)}, "
            f"{significant(abs(point.off))} px too {'much' if point.off > 0 else 'little'}; "
            f"bad with probability {percent(point.bad_probability)}"
        )
        return line + "".join(s.beside(point.label) for s in self.shared)

    @property
    def headline(self) -> str:
        """The verdict behind what is against the model, in a few words."""
        why = dict.fromkeys(f.because for f in self.findings if f.withholds)
        first = f"Look at the model first: {'; '.join(why)}. " if why else ""
        return first + self.verdict

    @property
    def verdict(self) -> str:
        """Whether the choice of the order depends on how bad points are treated, in words."""
        return verdict_words(self.treatments)

    def _repr_html_(self) -> str:
        """Show the model's own faults, the verdict and the suspicious points in a notebook."""
        data = self.data
        rows = [
            [p.label, f"{p.measured:g}", f"{p.off:+.3g}", percent(p.bad_probability)]
            for p in self.suspicious
        ]
        caption = f"Suspicious points of {data.axis} at order {self.order}, by the outlier mixture"
        heads = ["point", f"{data.axis}, px", "off, px", "P(bad)"]
        shown = table(caption, heads, rows) if rows else ""
        first = bullets("Look at the model first", self.against_the_model)
        last = bullets("Caveats", self.caveats)
        return first + paragraph(f"{data.axis}: {self.verdict}") + shown + last


@dataclass(frozen=True, eq=False)
class OutlierStudy(ByAxis[AxisOutliers]):
    """Bad points of every axis.

    Attributes
    ----------
    significance : float
        Of the chi-squared elimination, family-wise.
    settings : Settings
        Noise level, prior, seed and sampling effort.
    noises : tuple of StudentT, OutlierMixture
        The noise models that know bad points.
    origin : dict or None
        The provenance of the run it was read from; None where it was computed just now.
    derived : dict of str to Any
        What else took long, by name: a run keeps it.
    """

    axes: dict[str, AxisOutliers]
    points: Correspondences
    significance: float
    settings: Settings
    noises: tuple[StudentT, OutlierMixture]
    origin: dict[str, Any] | None = None
    derived: dict[str, Any] = field(default_factory=dict, repr=False)

    @property
    def sound(self) -> bool:
        """Whether every evidence can be trusted."""
        return all(axis.sound for axis in self.axes.values())

    def to_dataframe(self) -> pd.DataFrame:
        """Points of every axis in a data frame of pandas, a row each, the worst first."""
        return bad_points_frame(self)

    def treatments_dataframe(self) -> pd.DataFrame:
        """Orders under each treatment of bad points in a data frame of pandas."""
        return treatments_frame(self)

    def __repr__(self) -> str:
        lines = [f"  {name}: {axis.headline}" for name, axis in self.axes.items()]
        return "\n".join(["<OutlierStudy", *lines]) + ">"

    def _repr_html_(self) -> str:
        """Show every axis in a notebook."""
        return "".join(axis._repr_html_() for axis in self.axes.values())
