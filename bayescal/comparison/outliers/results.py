"""What an analysis of bad points found: small frozen values, and what they say in words."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from scipy.special import logsumexp

from bayescal.comparison import convert
from bayescal.comparison.defence.other_noise import ERRORS, MENTION
from bayescal.comparison.evidence import strength
from bayescal.comparison.findings.finding import Finding
from bayescal.comparison.judged import Judged
from bayescal.comparison.outliers.records import Elimination, PointRecord
from bayescal.comparison.outliers.shared_errors import SharedError
from bayescal.noise.choice import NOISE_WORDS
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

# 2 ln B above which Gaussian noise is called wrong rather than doubtful: strong evidence.
STRONG = 6.0


@dataclass(frozen=True, eq=False)
class Treatment:
    """One way of treating bad points, and the orders compared under it.

    Attributes
    ----------
    name : str
        In words.
    n_points : int
        Points compared on. Evidences of fewer points are of other data: only orders, not
        treatments, can be compared by them.
    orders : tuple of Judged
        Ascending, with probabilities among themselves.
    """

    name: str
    n_points: int
    orders: tuple[Judged, ...]

    @property
    def noise(self) -> str:
        """Name of the noise model."""
        return self.orders[0].key.noise

    @property
    def log_evidence(self) -> dict[int, float]:
        """Of every order, nat."""
        return {j.key.orders[0]: j.log_evidence or 0.0 for j in self.orders}

    @property
    def probability(self) -> dict[int, float]:
        """Posterior probability of each order under this treatment."""
        return {j.key.orders[0]: j.probability or 0.0 for j in self.orders}

    @property
    def warnings(self) -> dict[int, tuple[str, ...]]:
        """Why an evidence should not be trusted, by order; only those that should not."""
        return {j.key.orders[0]: j.warnings for j in self.orders if j.warnings}

    @property
    def order(self) -> int:
        """The most probable order."""
        values = self.log_evidence
        return max(values, key=lambda k: (values[k], -k))

    @property
    def total(self) -> float:
        """Log evidence, orders equally probable beforehand."""
        values = list(self.log_evidence.values())
        return float(logsumexp(values)) - math.log(len(values))

    @property
    def total_error(self) -> float:
        """Monte Carlo error of `total`, nat."""
        return math.hypot(
            *((j.probability or 0.0) * (j.log_evidence_error or 0.0) for j in self.orders)
        )


@dataclass(frozen=True, eq=False)
class AxisOutliers:
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
    def explanations(self) -> tuple[str, ...]:
        """A sentence for each suspicious point, or for those that share an error."""
        together = {label for s in self.shared if s.together for label in s.points}
        lines = [self._together(s) for s in self.shared if s.together]
        lines += [self._alone(p) for p in self.suspicious if p.label not in together]
        return tuple(lines)

    def _alone(self, point: PointRecord) -> str:
        unit = "" if self.data.axis == "y" else " px"
        predicted = rounded(point.predicted, point.predicted_sd)
        line = (
            f"point {point.label}: {self.data.axis} = {point.measured:g} where the mixture "
            f"predicts {predicted} ± {significant(point.predicted_sd)}, "
            f"{significant(abs(point.off))}{unit} too {'much' if point.off > 0 else 'little'}; "
            f"bad with probability {percent(point.bad_probability)}"
        )
        for s in self.shared:
            if point.label in s.points and s.good:
                names = ", ".join(s.good[:4])
                line += (
                    f"; {_points(s.good)} {names} with the same {_coordinates(s)} "
                    f"{'do' if len(s.good) > 1 else 'does'} not err, so that a misread pixel is "
                    "likelier than a wrong world value"
                )
            elif point.label in s.points and len(s.points) > 1:
                others = ", ".join(name for name in s.points if name != point.label)
                line += f"; it shares {_coordinates(s)} with {others}, but they err differently"
        return line

    def _together(self, shared: SharedError) -> str:
        names = " and ".join([", ".join(shared.points[:-1]), shared.points[-1]])
        line = (
            f"points {names} share {_coordinates(shared)} and err by the same "
            f"{significant(shared.error)} px (to within {significant(shared.spread, 1)} px): one "
            "wrong world value rather than several misreadings"
        )
        if shared.explained_by is not None:
            coordinate = next(iter(shared.coordinates))
            stated = shared.coordinates[coordinate]
            line += (
                f"; {coordinate} = {significant(stated + shared.explained_by, 3)} in place of "
                f"{stated:g} would explain it"
            )
        return line

    @property
    def headline(self) -> str:
        """The verdict behind what is against the model, in a few words."""
        why = dict.fromkeys(f.because for f in self.findings if f.withholds)
        first = f"Look at the model first: {'; '.join(why)}. " if why else ""
        return first + self.verdict

    @property
    def verdict(self) -> str:
        """Whether the choice of the order depends on how bad points are treated, in words."""
        orders = {t.name: t.order for t in self.treatments}
        if len(set(orders.values())) == 1:
            text = f"Order {self.order} wins however bad points are treated"
        else:
            listed = ", ".join(f"{k} under {name}" for name, k in orders.items())
            text = f"The choice depends on how bad points are treated: order {listed}"
        return f"{text}. {self.noise_verdict} {self._closest()}".strip()

    def _closest(self) -> str:
        """Name the order that comes closest under another treatment than Gaussian noise."""
        gaussian = self.treatments[0]
        changed = []
        for t in self.treatments[1:]:
            values = t.log_evidence
            rest = [k for k in values if k != t.order]
            if not rest:
                continue
            second = max(rest, key=lambda k: values[k])
            before = sorted(gaussian.log_evidence, key=lambda k: -gaussian.log_evidence[k])
            if len(before) > 1 and second != before[1]:
                gap = values[t.order] - values[second]
                changed.append(f"order {second}, {gap:.1f} nat behind, under {t.name}")
        if not changed:
            return ""
        return f"The runner-up changes: {'; '.join(changed)}."

    @property
    def noise_verdict(self) -> str:
        """Which noise model the data prefer, all orders taken together, in words."""
        gaussian = self.treatments[0]
        others = [t for t in self.treatments[1:] if t.n_points == len(self.data)]
        best = max(others, key=lambda o: o.total)
        lead = best.total - gaussian.total
        doubt = " (an uncertain evidence)" if best.warnings else ""
        if lead > MENTION / 2 and lead > ERRORS * best.total_error:
            kind = "the wrong" if 2 * lead > STRONG else "a doubtful"
            return (
                f"Gaussian noise is {kind} assumption here: {NOISE_WORDS[best.noise]} noise has "
                f"2 ln B = {2 * lead:.1f} against it{doubt}, {strength(lead)} (Kass & Raftery)."
            )
        if -lead > MENTION / 2:
            return (
                f"Gaussian noise is enough: it has 2 ln B = {-2 * lead:.1f} against the best "
                f"robust noise{doubt}, {strength(-lead)} (Kass & Raftery)."
            )
        return (
            f"Whether the noise is Gaussian the data do not tell: 2 ln B = {2 * lead:.1f} for "
            f"{NOISE_WORDS[best.noise]} noise{doubt}."
        )


@dataclass(frozen=True, eq=False)
class OutlierStudy:
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

    def __iter__(self) -> Iterator[AxisOutliers]:
        return iter(self.axes.values())

    def __len__(self) -> int:
        return len(self.axes)

    def __contains__(self, axis: object) -> bool:
        return axis in self.axes

    def __getitem__(self, axis: str) -> AxisOutliers:
        try:
            return self.axes[axis]
        except KeyError:
            names = ", ".join(self.axes)
            raise KeyError(f"axis {axis!r} was not looked at; axes: {names}") from None

    def to_dataframe(self) -> pd.DataFrame:
        """Points of every axis in a data frame of pandas, a row each, the worst first."""
        return convert.bad_points_frame(self)

    def summary(self) -> pd.DataFrame:
        """Orders under each treatment of bad points in a data frame of pandas."""
        return convert.treatments_frame(self)

    def __repr__(self) -> str:
        lines = [f"  {name}: {axis.headline}" for name, axis in self.axes.items()]
        return "\n".join(["<OutlierStudy", *lines]) + ">"


def _coordinates(shared: SharedError) -> str:
    return ", ".join(f"{name} = {value:g}" for name, value in shared.coordinates.items())


def _points(names: tuple[str, ...]) -> str:
    return "points" if len(names) > 1 else "point"
