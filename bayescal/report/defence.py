"""The defence of a verdict, for a terminal and for the result document."""

from __future__ import annotations

from typing import Any

from rich.console import Group, RenderableType
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from bayescal.comparison.argument import SMALL_SAMPLE
from bayescal.comparison.defence import Defence
from bayescal.comparison.results import AxisComparison
from bayescal.comparison.stability import Bootstrap, Removal, joint_probabilities
from bayescal.comparison.verdict import percent
from bayescal.report.rounding import significant
from bayescal.report.tables import start_table


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
    lines = [
        "elpd: exact leave-one-out, one pixel value left out at a time; behind: the best order. "
        "PSIS: the same from the draws, with its Monte Carlo error; Pareto k above 0.7 makes that "
        "check unreliable for the point."
    ]
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
    if defence.resampled:
        parts.append(_stability_table(axis, defence))
    parts += [Padding(Text(line), (0, 0, 0, 2)) for line in _world_lines(axis)]
    return Group(*parts)


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
    heads = ["elpd", "SE", "behind", "SE", "p eff", "PSIS", "k max", *["by group"] * grouped]
    table = start_table("   order", *heads)
    for k, found in defence.prediction.items():
        loo = found.loo
        cells = [
            f"{loo.elpd:.1f}",
            f"{loo.se:.1f}",
            f"{abs(found.difference):.1f}",
            f"{found.difference_se:.1f}",
            f"{loo.p_eff:.1f}",
            "" if found.psis_elpd is None else f"{found.psis_elpd:.1f} ± {found.psis_mcse:.1f}",
            "" if found.pareto_k is None else f"{found.pareto_k.max():.2f}",
        ]
        if grouped:
            cells.append("" if found.group_elpd is None else f"{found.group_elpd:.1f}")
        _add(table, axis, k, cells)
    return table


def _stability_table(axis: AxisComparison, defence: Defence) -> RenderableType:
    beyond = defence.beyond.probability if defence.beyond is not None else {}
    heads = [f"wins, {b.unit}s resampled" for b in defence.resampled]
    table = start_table("   order", *heads, *["prob. with orders beyond"] * bool(beyond))
    for k in beyond:
        shares = [percent(b.share[k]) if k in b.share else "" for b in defence.resampled]
        _add(table, axis, k, [*shares, percent(beyond[k])])
    return table


def _add(table: Table, axis: AxisComparison, order: int, cells: list[str]) -> None:
    chosen = order == axis.verdict.order
    table.add_row(f"{' >'[chosen]}  {order:>5}", *cells, style="bold" if chosen else "")


def joint_view(first: AxisComparison, second: AxisComparison) -> RenderableType:
    """Show the probability of every pair of orders of two axes."""
    chances = [
        {r.order: r.probability for r in axis.orders if r.probability is not None}
        for axis in (first, second)
    ]
    if not all(chances):
        return Text("")
    names = first.data.axis, second.data.axis
    table = start_table(
        f"joint, {names[0]} \\ {names[1]}", *(f"{names[1]} order {k}" for k in chances[1])
    )
    pairs = joint_probabilities(*chances)
    for k, row in zip(chances[0], pairs, strict=True):
        table.add_row(f"{names[0]} order {k}", *(percent(float(p)) for p in row))
    return table


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
