"""The defence of a verdict, for a terminal and for the result document."""

from __future__ import annotations

from typing import Any

import numpy as np
from rich.console import Group, RenderableType
from rich.padding import Padding
from rich.text import Text

from bayescal.comparison.argument import SMALL_SAMPLE
from bayescal.comparison.defence import Defence, Prediction
from bayescal.comparison.results import AxisComparison
from bayescal.comparison.sensitivity import TauSensitivity
from bayescal.comparison.stability import Bootstrap, Removal, joint_probabilities
from bayescal.comparison.verdict import percent
from bayescal.models.noise.gaussian import GAUSSIAN
from bayescal.report.noise import noises_document, noises_table
from bayescal.report.tables import make_table
from bayescal.rounding import significant

EXACT_ELPD = (
    "elpd: exact leave-one-out, one pixel value left out at a time; behind: the best order. "
    "PSIS: the same from the draws, with its Monte Carlo error."
)
SAMPLED_ELPD = (
    "elpd: leave-one-out from the draws (PSIS), one pixel value left out at a time, with its "
    "Monte Carlo error beside PSIS; behind: the best order."
)
# Where the table over tau is evaluated: nodes of the grid, fractions of the image.
SHOWN_TAU = (0.001, 0.00316228, 0.01, 0.0316228, 0.1, 0.316228, 1.0)


def defence_view(axis: AxisComparison) -> RenderableType:
    """Show prediction, prior sensitivity and stability of one axis."""
    defence = axis.defence
    if defence is None:
        return Text("")
    parts: list[RenderableType] = [
        Text(""),
        Text(f"  Defence of {axis.data.axis}: prediction and stability", style="bold"),
        _prediction_table(axis, defence),
    ]
    gaussian = axis.noise_model.name == GAUSSIAN.name
    lines = [EXACT_ELPD if gaussian else SAMPLED_ELPD]
    lines += _influential(axis, defence)
    if len(axis.data) < SMALL_SAMPLE:
        lines.append(
            f"With {len(axis.data)} points the standard errors may be up to twice too small "
            "(Sivula et al. 2020)."
        )
    if defence.group_source is not None:
        lines.append(
            f"Groups: points that share a {defence.group_source.removeprefix('column ')}. Their "
            "neighbours make leave-one-out optimistic; by group is the harder test."
        )
    parts += [Padding(Text(line), (0, 0, 0, 2)) for line in lines]
    if defence.tau is not None:
        parts.append(_tau_table(axis, defence.tau))
    if defence.resampled:
        parts.append(_stability_table(axis, defence))
    if defence.noises:
        parts.append(noises_table(axis, defence.noises))
    last = _world_lines(axis)
    if not gaussian:
        from bayescal.comparison.robust_defence import LEFT_OUT

        last.append(LEFT_OUT)
    parts += [Padding(Text(line), (0, 0, 0, 2)) for line in last]
    return Group(*parts)


def _influential(axis: AxisComparison, defence: Defence) -> list[str]:
    """Name the points whose Pareto k at the order shown is beyond the limit."""
    found = defence.prediction.get(axis.chosen.order)
    if found is None or not found.influential or found.k_limit is None:
        return []
    names = ("points " if len(found.influential) > 1 else "point ") + ", ".join(
        found.influential[:6]
    )
    more = f" and {len(found.influential) - 6} more" if len(found.influential) > 6 else ""
    return [
        f"Pareto k above {found.k_limit:.2g} at order {axis.chosen.order}: {names}{more}; "
        "there PSIS can't be trusted: the draws can't tell what is predicted without the point."
    ]


def _world_lines(axis: AxisComparison) -> list[str]:
    if not axis.world_units:
        return []
    first = axis.world_units[0]
    parts = [
        f"in {u.coordinate} {significant(u.nearest)} px and {significant(u.median)} px"
        for u in axis.world_units
    ]
    return [
        "Errors of the world coordinates are not stated. One unit of error is worth, at the "
        f"nearest point ({first.nearest_point}) and at the one of median depth "
        f"({first.median_point}): {'; '.join(parts)}."
    ]


def _prediction_table(axis: AxisComparison, defence: Defence) -> RenderableType:
    grouped = any(p.group_elpd is not None for p in defence.prediction.values())
    heads = ["elpd", "SE", "behind", "± SE", "p eff", "PSIS", "k max", *["by group"] * grouped]
    rows = []
    for k, found in defence.prediction.items():
        loo = found.loo
        cells = [
            _compact(loo.elpd),
            _compact(loo.se),
            _compact(abs(found.difference)),
            _compact(found.difference_se),
            _compact(loo.p_eff),
            _psis_words(found),
            _k_words(found),
        ]
        if grouped:
            cells.append("" if found.group_elpd is None else _compact(found.group_elpd))
        rows.append([_marked(axis, k), *cells])
    orders = list(defence.prediction)
    bold = orders.index(axis.verdict.order) if axis.verdict.order in orders else None
    return make_table(["   order", *heads], rows, bold=bold, spare=("p eff", "SE", "k max", "PSIS"))


def _psis_words(found: Prediction) -> str:
    if found.psis_elpd is None or found.psis_mcse is None:
        return ""
    return f"{_compact(found.psis_elpd)} ± {_compact(found.psis_mcse)}"


def _k_words(found: Prediction) -> str:
    if found.pareto_k is None:
        return ""
    largest = float(found.pareto_k.max())
    return f"{largest:.2f}" if largest < 10 else "bad"


def _compact(value: float) -> str:
    return f"{value:.1f}" if abs(value) < 1e5 else f"{value:.3g}"


def _tau_table(axis: AxisComparison, found: TauSensitivity) -> RenderableType:
    """Log evidence of every order at a few fixed tau."""
    columns = [int(np.argmin(np.abs(np.log(found.tau / tau)))) for tau in SHOWN_TAU]
    heads = ["   ln Z at fixed tau", *(f"{significant(100 * tau)}%" for tau in SHOWN_TAU)]
    rows = [
        [_marked(axis, k), *(_compact(float(row[i])) for i in columns)]
        for k, row in zip(found.orders, found.log_evidence, strict=True)
    ]
    orders = list(found.orders)
    bold = orders.index(axis.verdict.order) if axis.verdict.order in orders else None
    return make_table(heads, rows, bold=bold)


def _stability_table(axis: AxisComparison, defence: Defence) -> RenderableType:
    beyond = defence.beyond.probability if defence.beyond is not None else {}
    heads = [f"wins, {b.unit}s resampled" for b in defence.resampled]
    rows = []
    for k in beyond:
        shares = [percent(b.share[k]) if k in b.share else "" for b in defence.resampled]
        rows.append([_marked(axis, k), *shares, percent(beyond[k])])
    heads = ["   order", *heads, "prob. with orders beyond"]
    orders = list(beyond)
    bold = orders.index(axis.verdict.order) if axis.verdict.order in orders else None
    return make_table(heads, rows, bold=bold)


def _marked(axis: AxisComparison, order: int) -> str:
    return f"{' >'[order == axis.verdict.order]}  {order:>5}"


def joint_view(first: AxisComparison, second: AxisComparison) -> RenderableType:
    """Show the probability of every pair of orders of two axes."""
    chances = [
        {r.order: r.probability for r in axis.orders if r.probability is not None}
        for axis in (first, second)
    ]
    if not all(chances):
        return Text("")
    names = first.data.axis, second.data.axis
    heads = [f"joint, {names[0]} \\ {names[1]}", *(f"{names[1]} order {k}" for k in chances[1])]
    rows = [
        [f"{names[0]} order {k}", *(percent(float(p)) for p in row)]
        for k, row in zip(chances[0], joint_probabilities(*chances), strict=True)
    ]
    return make_table(heads, rows, spare=heads[:0:-1])


def defence_document(defence: Defence) -> dict[str, Any]:
    """Collect a defence's numbers as JSON values."""
    tau = defence.tau
    beyond = defence.beyond
    return {
        "tau_sensitivity": None
        if tau is None
        else {
            "tau": tau.tau.tolist(),
            "orders": list(tau.orders),
            "log_evidence": tau.log_evidence.tolist(),
            "probability": tau.probability.tolist(),
            "wins": [{"order": w.order, "tau": [w.lower, w.upper]} for w in tau.wins],
        },
        "groups": defence.group_source,
        "points_that_matter": [_removal(r) for r in defence.points_that_matter],
        "groups_that_matter": [_removal(r) for r in defence.groups_that_matter],
        "bootstrap": [_bootstrap(b) for b in defence.resampled],
        "beyond": None
        if beyond is None
        else {
            "probability": {str(k): p for k, p in beyond.probability.items()},
            "winner": beyond.winner,
        },
        "noises": noises_document(defence.noises),
        "worth": [
            {"order": w.order, "largest_px": w.largest, "sd_px": w.sd, "at": w.at}
            for w in defence.worth
        ],
    }


def _removal(removal: Removal) -> dict[str, Any]:
    return {
        "name": removal.name,
        "points": removal.size,
        "order": removal.order,
        "log_bayes_factor": removal.log_bayes_factor,
    }


def _bootstrap(found: Bootstrap) -> dict[str, Any]:
    share = {str(k): s for k, s in found.share.items()}
    return {"unit": found.unit, "resamples": found.resamples, "share": share}
