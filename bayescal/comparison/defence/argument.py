"""The verdict's paragraph once a referee's questions were answered."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence

from bayescal.comparison.criteria.information import Criteria
from bayescal.comparison.defence.results import Defence, Prediction
from bayescal.comparison.defence.stability import Removal
from bayescal.comparison.finding import limits
from bayescal.comparison.findings.beyond_range import beyond_range
from bayescal.comparison.findings.edge import UNSEEN
from bayescal.comparison.orders.beyond import Beyond
from bayescal.comparison.orders.verdict import AxisVerdict
from bayescal.rounding import counted, percent, significant
from bayescal.rounding import grouped as digits

# Leave-one-out contradicts the verdict where its best is ahead by more than both.
CLEAR_ELPD = 4.0
CLEAR_SE = 2.0
SMALL_SAMPLE = 100  # below it the standard error of elpd may be up to twice too small


def argue(
    verdict: AxisVerdict, defence: Defence, criteria: Mapping[int, Criteria], size: float
) -> AxisVerdict:
    """Add what the defence found to a verdict's text and caveats.

    Parameters
    ----------
    criteria : mapping of int to Criteria
        By order.
    size : float
        Image size along the axis, px.
    """
    if verdict.order is None:
        return verdict
    text = [_worth(defence)]
    if len(criteria) > 1:  # else there is nothing to win against
        text += [_tau(verdict.order, defence, size), _resampled(defence, verdict.order)]
        removed = defence.points_that_matter, defence.groups_that_matter
        grouped, further = defence.group_source is not None, defence.further_points
        text.append(removal_words(*removed, grouped=grouped, further=further))
    text.append(_disagreement(verdict, criteria))
    text.append(_leave_one_out(verdict.order, defence.prediction))
    more = []
    clear = _clear_contradiction(verdict.order, defence.prediction)
    if clear:
        more.append(limits("leave-one-out", clear))
    if defence.beyond is not None:
        kept = tuple(f for f in verdict.findings if f.kind != UNSEEN)
        verdict = dataclasses.replace(verdict, findings=kept)
        at_edge = len(criteria) > 1 and verdict.order == max(criteria)
        more += beyond_range(defence.beyond, at_edge=at_edge)
        text.append(_beyond(defence.beyond))
    return verdict.with_findings(more, *text)


def _beyond(found: Beyond) -> str:
    if found.winner is not None or not found.orders:
        return ""
    fitted = [k for k in found.probability if k not in found.orders]
    where = "Beyond the range" if len(fitted) > 1 else f"Above order {fitted[0]}"
    orders = ", ".join(str(k) for k in found.orders)
    together = percent(sum(found.probability[k] for k in found.orders))
    return f"{where}, orders {orders} were tried: none would take its place ({together} together)."


def _worth(defence: Defence) -> str:
    if not defence.worth:
        return ""
    parts = [
        f"order {w.order} by at most {significant(w.largest)} px (sd {significant(w.sd)})"
        for w in defence.worth
    ]
    return f"Over the domain its prediction differs from that of {', '.join(parts)}."


def _tau(order: int, defence: Defence, size: float) -> str:
    if defence.tau is None:
        return ""
    wins = defence.tau.possible
    if len(wins) == 1 and wins[0].order == order:
        return (
            "It wins at every strength tau that these data leave possible, "
            f"{_share(wins[0].lower)} to {_share(wins[0].upper)} of the image "
            f"({significant(wins[0].lower * size)} to {significant(wins[0].upper * size)} px)."
        )
    parts = [
        f"order {w.order} from {_share(w.lower)} to {_share(w.upper)} of the image "
        f"({significant(w.lower * size)} to {significant(w.upper * size)} px)"
        for w in wins
    ]
    return f"Were the strength tau fixed, the winner would be {', '.join(parts)}."


def _share(tau: float) -> str:
    return f"{significant(100 * tau)}%"


def _resampled(defence: Defence, order: int) -> str:
    parts = [
        f"{percent(b.share.get(order, 0.0))} of {b.resamples} resamples of the {b.unit}s"
        for b in defence.resampled
    ]
    return f"It wins in {' and '.join(parts)}." if parts else ""


def removal_words(
    points: Sequence[Removal], groups: Sequence[Removal], *, grouped: bool, further: int = 0
) -> str:
    """Say which points' and, where they are `grouped`, groups' removal changes the winner.

    `further` points are not listed.
    """
    parts = []
    for kind, found in (("point", points), *((("group", groups),) if grouped else ())):
        if not found:
            parts.append(f"no single {kind}'s removal changes it")
            continue
        shown = [
            f"without {kind} {r.name}"
            + (f" ({counted(r.size, 'point')})" if kind == "group" else "")
            + f" {r.winner} would win (ln B {r.log_bayes_factor:.1f})"
            for r in found[:4]
        ]
        left = max(len(found) - 4, 0) + (further if kind == "point" else 0)
        more = f" and {digits(left)} more" if left else ""
        parts.append(", ".join(shown) + more)
    joined = "; ".join(parts)
    return joined[0].upper() + joined[1:] + "."


def _disagreement(verdict: AxisVerdict, criteria: Mapping[int, Criteria]) -> str:
    first, second = verdict.aicc_order, verdict.bic_order
    if first is None or second is None or first == second:
        return ""
    name = verdict.aic_name
    low, high = sorted((first, second))
    asks = {
        label: _penalty(criteria[high], key) - _penalty(criteria[low], key)
        for label, key in ((name, name.lower()), ("BIC", "bic"))
    }
    return (
        f"{name} and BIC disagree because for going from order {low} to {high} {name} asks "
        f"{asks[name]:.1f} of twice the log likelihood, BIC {asks['BIC']:.1f}."
    )


def _penalty(found: Criteria, key: str) -> float:
    """Subtract -2 lnL from a criterion."""
    value = getattr(found, key)
    return float(value + 2 * (found.log_likelihood or 0.0))


def _leave_one_out(order: int, prediction: dict[int, Prediction]) -> str:
    if order not in prediction or len(prediction) == 1:
        return ""
    best = max(prediction, key=lambda k: prediction[k].loo.elpd)
    if best == order:
        rest = [k for k in prediction if k != order]
        runner = max(rest, key=lambda k: prediction[k].loo.elpd)
        found = prediction[runner]
        return (
            f"Leave-one-out puts it first too; order {runner} is behind by "
            f"{_lead(-found.difference, found.difference_se)}."
        )
    found = prediction[order]
    lead = _lead(-found.difference, found.difference_se)
    return (
        f"Leave-one-out puts order {best} ahead by {lead}: it asks only for prediction, the "
        "evidence also how much of the prior the data use up."
    )


def _lead(ahead: float, se: float) -> str:
    similar = "; below 4, predictions are similar" if ahead < CLEAR_ELPD else ""
    return f"{ahead:.1f} (SE {se:.1f}{similar})"


def _clear_contradiction(order: int, prediction: dict[int, Prediction]) -> str:
    if order not in prediction:
        return ""
    found = prediction[order]
    ahead, se = -found.difference, found.difference_se
    if ahead > CLEAR_ELPD and ahead > CLEAR_SE * se:
        best = max(prediction, key=lambda k: prediction[k].loo.elpd)
        return (
            f"leave-one-out clearly prefers order {best}: ahead by {ahead:.1f}, more than twice "
            f"its standard error {se:.1f}"
        )
    return ""
