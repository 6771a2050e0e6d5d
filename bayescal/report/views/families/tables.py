"""Models of r and c as tables: all compared, one model's parameters, their correlation."""

from __future__ import annotations

from collections.abc import Sequence

from bayescal.comparison.criteria.information import ACROSS
from bayescal.comparison.criteria.leave_one_out import LeaveOneOut, paired_difference
from bayescal.comparison.families.result import JointModel
from bayescal.comparison.families.results import FamilyComparison, GroupedErrors
from bayescal.inference.sampled_posterior import SampledPosterior
from bayescal.report.numbers import correlations
from bayescal.report.table import Cell, Column, Table, number_cell
from bayescal.rounding import percent, rounded, significant

UNITS = {
    "focal": "px",
    "centre": "px",
    "rotation": "deg",
    "position": "world",
    "sigma": "px",
    "alpha": "px",
    "beta": "px",
    "tau": "of image",
}
# The most probable models, and the best of every family and position.
LISTED = 12
EXACT = 1e-5  # nat: an error below it is of rounding


def unit_of(name: str) -> str:
    """Say the unit of a parameter; nothing where it has none."""
    return UNITS.get(name.split("_")[0], "")


def shortlist(found: FamilyComparison) -> list[int]:
    """Say which models a short table shows: the first, and the best of each kind."""
    seen: set[tuple[str, str]] = set()
    out = []
    for i, model in enumerate(found.models):
        kind = model.key.family, model.key.position
        if i < LISTED or kind not in seen:
            out.append(i)
        seen.add(kind)
    return out


def models_table(found: FamilyComparison, rows: Sequence[int]) -> Table:
    """One row for each model listed, the most probable first."""
    best, several = found.best, len(found.models) > 1  # one alone has no probability
    values = [m.criteria.values for m in found.models]
    lowest = {
        c.key: min((v[c.key] or 0.0 for v in values if v.get(c.key) is not None), default=0.0)
        for c in ACROSS
    }
    columns = (
        Column("family"),
        Column("order", "of r and of c in the separable family; radial coefficients of a pinhole"),
        Column("position", "of the camera: exact as stated, or free to be inferred"),
        Column("K", "coefficients, inferred sigmas and a free position"),
        *(Column(f"d{c.name}", f"{c.meaning}; less the smallest") for c in ACROSS),
        Column("ln Z", "natural logarithm of the evidence; !: not to be trusted"),
        Column("±", "its Monte Carlo error, nat; exact where it has a closed form", "± ln Z"),
        Column("elpd", "leave-one-out, r and c of a point together; ?: not to be trusted"),
        Column("±", "its standard error", "± elpd"),
        Column("d elpd", "less the most probable model's, with the paired error", "Δ elpd"),
        Column("prob.", "posterior probability of the model", "probability"),
    )
    cells = []
    for i in rows:
        m = found.models[i]
        flag = "" if m.sound else "!"
        cells.append(
            (
                Cell(m.key.family),
                Cell(m.key.order, float(m.key.orders[0])),
                Cell(m.key.position),
                Cell(str(m.criteria.n_parameters), m.criteria.n_parameters),
                *(_above(m.criteria.values.get(key), low) for key, low in lowest.items()),
                Cell(f"{m.log_evidence:.2f}{flag}", m.log_evidence),
                Cell(error_words(m.log_evidence_error), m.log_evidence_error),
                Cell("") if m.loo is None else Cell(elpd_words(m.loo), m.loo.elpd),
                number_cell(None if m.loo is None else m.loo.se, lambda v: f"{v:.1f}"),
                _difference(m, best),
                number_cell(found.probabilities[i] if several else None, percent),
            )
        )
    marked = 0 if 0 in rows[:1] else None
    return Table(columns, tuple(cells), marked, True, ("dAIC", "K", "±"), naming=3)


def _above(value: float | None, lowest: float) -> Cell:
    """Show how far a criterion lies above the smallest; empty where there is none."""
    return number_cell(value, lambda v: f"{v - lowest:.1f}")


def error_words(error: float) -> str:
    """Error of a log evidence, to the digit that counts."""
    return "exact" if error < EXACT else significant(error, 1)


def elpd_words(loo: LeaveOneOut) -> str:
    """Sum of the terms, marked where it should not be trusted."""
    return f"{loo.elpd:.1f}" + "?" * (not loo.reliable)


def _difference(model: JointModel, best: JointModel) -> Cell:
    if model is best or model.loo is None or best.loo is None:
        return Cell("")
    total, se = paired_difference(model.loo, best.loo)
    doubt = "" if model.loo.reliable and best.loo.reliable else "?"
    return Cell(f"{total:+.1f}{doubt} ({se:.1f})", total)


def parameters_table(model: JointModel, grouped: GroupedErrors | None = None) -> Table:
    """Parameters of a model: of its draws, weighted draws or closed form."""
    heads = [Column("unit"), Column("mean"), Column("sd")]
    if grouped is not None:
        heads.append(Column("sd, groups", f"by the jackknife over {grouped.count} groups"))
    heads.append(Column("95% interval", "central"))
    if model.posterior is None:
        found, how = model.summaries, "exact" if model.exact else "weighted"
        rows = [_summary_cells(p.name, p.mean, p.sd, p.interval, grouped) for p in found]
        return Table((Column(f"{model.key} ({how})", title="parameter"), *heads), tuple(rows))
    heads += [
        Column("MCSE", "Monte Carlo standard error of the mean"),
        Column("ESS", "the smaller of bulk and tail effective sample size"),
        Column("R-hat", "rank-normalised and split, over independent ensembles"),
    ]
    cells = []
    for p in model.posterior.parameters:
        cells.append(
            (
                *_summary_cells(p.name, p.mean, p.sd, p.interval, grouped),
                Cell(significant(p.mcse_mean, 1), p.mcse_mean),
                Cell(f"{p.ess:.0f}", p.ess),
                Cell(f"{p.rhat:.3f}", p.rhat),
            )
        )
    head = Column(str(model.key), title="parameter")
    return Table((head, *heads), tuple(cells), spare=("MCSE",))


def _summary_cells(
    name: str,
    mean: float,
    sd: float,
    interval: tuple[float, float],
    grouped: GroupedErrors | None,
) -> tuple[Cell, ...]:
    low, high = interval
    return (
        Cell(name),
        Cell(unit_of(name)),
        Cell(rounded(mean, sd), mean),
        Cell(significant(sd), sd),
        *(() if grouped is None else (number_cell(grouped.sd.get(name), significant),)),
        Cell(f"{rounded(low, sd)} to {rounded(high, sd)}", high - low),
    )


def correlation_table(posterior: SampledPosterior) -> Table:
    """Lower half of the correlation matrix."""
    matrix = correlations(posterior)
    numbers = [str(i + 1) for i in range(len(matrix))]
    rows = [
        (
            Cell(f"{i + 1} {name}"),
            *(Cell(f"{value:.2f}", value) for value in matrix[i, : i + 1].tolist()),
            *(Cell("") for _ in range(len(matrix) - i - 1)),
        )
        for i, name in enumerate(posterior.names)
    ]
    columns = (Column("correlation"), *map(Column, numbers))
    return Table(columns, tuple(rows), spare=tuple(numbers[::-1]))
