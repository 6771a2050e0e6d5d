"""Tables of lens models over many views."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bayescal.arrays import finite
from bayescal.comparison.criteria.leave_one_out import paired_difference
from bayescal.comparison.lenses.place import Place
from bayescal.comparison.lenses.results import JudgedLens, LensComparison
from bayescal.report.table import Cell, Column, Table, number_cell
from bayescal.rounding import percent, rounded, significant

SHOWN = 12  # lenses


def lenses_table(found: LensComparison, lenses: Sequence[JudgedLens]) -> Table:
    """Table of a row per lens, of some of those compared."""
    known = found.setting.level.sigma is not None
    columns = [
        Column("lens", "what maps a ray to a pixel"),
        Column("order", "radial coefficients"),
        Column("K", "parameters: lens, six for each view, sigma where inferred"),
        Column("RMS", "distance of points from the least-squares fit, px"),
        *([Column("chi2", "weighted sum of squares")] if known else []),
        Column("dBIC", "above the smallest; counts poses, and takes noise as independent"),
        Column("ln Z", "log evidence, error models and poses averaged"),
        Column("±", "its Monte Carlo error"),
        Column("P", "posterior probability, lenses equal before"),
        Column("elpd", "leave-one-view-out, the pose of the view integrated, nat"),
        Column("d elpd", "against the best, with its paired standard error"),
        Column(
            "inside",
            "largest difference of fitted predictions to the best lens where the points are, at "
            "infinity, after the turn that the poses absorb, px; the verdict adds its uncertainty",
        ),
        Column("image", "the same over the whole image, px"),
    ]
    least = min(j.bic for j in found.lenses)
    rows = []
    for judged in lenses:
        lost = judged.loo
        gap = ""
        if lost is not None and found.best.loo is not None and judged is not found.best:
            gap = "{:+.1f}±{:.1f}".format(*paired_difference(lost, found.best.loo))
        rows.append(
            (
                Cell(judged.name),
                number_cell(judged.candidate.order, lambda v: f"{v:.0f}"),
                Cell(str(judged.n_parameters), judged.n_parameters),
                number_cell(judged.rms, lambda v: f"{v:.4f}"),
                *([number_cell(judged.chi2, lambda v: f"{v:.0f}")] if known else []),
                number_cell(judged.bic - least, lambda v: f"{v:.1f}"),
                number_cell(judged.log_evidence, lambda v: f"{v:.2f}"),
                number_cell(judged.log_evidence_error, _error),
                Cell(percent(judged.probability), judged.probability),
                number_cell(None if lost is None else lost.elpd, lambda v: f"{v:.1f}"),
                Cell(gap),
                number_cell(judged.inside, _small),
                number_cell(judged.difference, _small),
            )
        )
    marked = 0 if found.best in lenses[:1] else None
    return Table(tuple(columns), tuple(rows), marked, True, ("elpd", "order", "image"))


def _error(value: float) -> str:
    return f"{value:.2f}" if value < 10 else "?"


def _small(value: float) -> str:
    return "-" if value == 0 else significant(value)


def parameters_table(found: LensComparison) -> Table:
    """Posterior of the best lens."""
    columns = (
        Column("parameter"), Column("mean"), Column("sd"), Column("95% interval"),
        Column("at corner, px", "displacement it makes at the image's corner"),
        Column("ESS"), Column("R-hat"),
    )  # fmt: skip
    amplitudes = corner_displacements(found.best, found)
    rows = []
    for p in found.posterior.parameters:
        interval = " to ".join(rounded(end, p.sd) for end in p.interval)
        rows.append(
            (
                Cell(p.name),
                Cell(rounded(p.mean, p.sd), p.mean),
                Cell(significant(p.sd), p.sd),
                Cell(interval),
                Cell(amplitudes.get(p.name, "")),
                Cell(f"{p.ess:.0f}"),
                Cell(f"{p.rhat:.3f}"),
            )
        )
    return Table(columns, tuple(rows))


def corner_displacements(best: JudgedLens, found: LensComparison) -> dict[str, str]:
    """Displacement at the image's corner of each coefficient, mean and sd, px."""
    model = best.evidence.problem.model
    at = {name: j for j, name in enumerate(model.names)}
    grouped = {j for g in model.groups if g.name != "bow" for j in g.columns}
    out = {}
    for name, j in at.items():
        if j in grouped:
            values = found.draws[:, j]
            sd = float(values.std(ddof=1))
            out[name] = f"{rounded(float(values.mean()), sd)} ± {significant(sd)}"
    return out


def places_table(found: LensComparison) -> Table:
    """How sure the projection is, at the centre and the worst of edges and corners."""
    columns = (
        Column("place"), Column("sd at infinity"), Column("sd at range"),
        Column("jackknife"), Column("halves"),
    )  # fmt: skip
    rows = []
    for name in ("centre", "edge", "corner"):
        group = [p for p in found.places if p.name.endswith(name)]
        worst = {
            column: _worst(group, column) for column in ("infinity", "near", "jackknife", "halves")
        }
        label = name if len(group) == 1 else f"{name}s, the worst"
        rows.append((Cell(label), *(number_cell(v, significant) for v in worst.values())))
    return Table(columns, tuple(rows))


def _worst(group: list[Place], column: str) -> float | None:
    known = [v for p in group if (v := getattr(p, column)) is not None]
    return max(known) if known else None


def gross_table(found: LensComparison) -> Table:
    """Table of a row per point that the error model can't explain."""
    lines = found.views.lines is not None
    columns = (
        Column("point", "as --without takes it"), *([Column("line", "of the file")] * lines),
        Column("r", "observed less where all others put it, px"), Column("c", "the same"),
        Column("off", "distance, px"), Column("p", "times the number of points"),
    )  # fmt: skip
    rows = []
    for point in found.gross:
        place = [Cell(point.place)] if lines else []
        sizes = (number_cell(v, lambda x: f"{x:.2f}") for v in (*point.shift, point.size))
        chance = number_cell(point.p_value, lambda v: f"{v:.1g}" if v >= 1e-4 else "<0.0001")
        rows.append((Cell(point.name), *place, *sizes, chance))
    return Table(columns, tuple(rows))


def bad_table(found: LensComparison, most: int) -> Table:
    """Table of a row per point that is bad or may be, the `most` likely ones."""
    lines, bad = found.views.lines is not None, found.bad
    columns = (
        Column("point", "as --without takes it"), *([Column("line", "of the file")] * lines),
        Column("r", "observed less where the good points put it, px"), Column("c", "the same"),
        Column("off", "distance, px"), Column("bad", "probability"),
    )  # fmt: skip
    rows = []
    for point in () if bad is None else bad.points[:most]:
        place = [Cell(point.place)] if lines else []
        far = map(finite, (*point.shift, point.size))
        sizes = (number_cell(v, lambda x: f"{x:.2f}") for v in far)
        chance = Cell(percent(point.probability), point.probability)
        rows.append((Cell(point.name), *place, *sizes, chance))
    return Table(columns, tuple(rows))


def views_table(found: LensComparison) -> Table:
    """Table of a row per view."""
    data, lost = found.setting.data, found.best.loo
    squares = (found.best.evidence.problem.noise**2).sum(axis=(1, 2))
    columns = (
        Column("view"), Column("points"), Column("rms", "of the residuals, px"),
        Column("elpd", "of the view from the others, nat"),
    )  # fmt: skip
    rows = []
    for v, name in enumerate(found.views.names):
        own = None if lost is None else float(lost.pointwise[v])
        spread = float(np.sqrt(squares[v] / data.counts[v]))
        rows.append(
            (
                Cell(name),
                number_cell(int(data.counts[v]), lambda n: f"{n:.0f}"),
                number_cell(spread, lambda x: f"{x:.3f}"),
                number_cell(own, lambda x: f"{x:.1f}"),
            )
        )
    return Table(columns, tuple(rows))
