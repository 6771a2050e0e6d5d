"""The verdict's paragraph once a referee's questions were answered."""

from __future__ import annotations

import dataclasses
import math

from bayescal.comparison.defence import Defence, Prediction
from bayescal.comparison.verdict import AxisVerdict, percent
from bayescal.report.rounding import significant

# Leave-one-out contradicts the verdict where its best is ahead by more than both.
CLEAR_ELPD = 4.0
CLEAR_SE = 2.0
SMALL_SAMPLE = 100  # below it the standard error of elpd may be up to twice too small


def argue(verdict: AxisVerdict, defence: Defence, n: int, size: float) -> AxisVerdict:
    """Add what the defence found to a verdict's text and caveats.

    Parameters
    ----------
    verdict : AxisVerdict
    defence : Defence
    n : int
        Number of points.
    size : float
        Image size along the axis, px.

    Returns
    -------
    AxisVerdict
    """
    text, caveats = [verdict.text], list(verdict.caveats)
    if verdict.order is None:
        return verdict
    text += [
        _worth(defence),
        _tau(verdict.order, defence, size),
        _resampled(defence, verdict.order),
    ]
    text += [_removals(defence), _disagreement(verdict, n)]
    text.append(_leave_one_out(verdict.order, defence.prediction))
    clear = _clear_contradiction(verdict.order, defence.prediction)
    if clear:
        caveats.append(clear)
    if defence.beyond is not None:
        winner = defence.beyond.winner
        reached = max(defence.beyond.probability)
        if winner is not None:
            caveats.append(
                f"order {winner}, beyond the compared range, would win "
                f"({percent(defence.beyond.probability[winner])} among orders up to {reached}): "
                "compare more orders"
            )
        else:
            text.append(f"No order up to {reached} would take its place.")
    return dataclasses.replace(
        verdict, text=" ".join(part for part in text if part), caveats=tuple(caveats)
    )


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
    wins = defence.tau.wins
    if len(wins) == 1 and wins[0].order == order:
        return "It wins at every fixed strength tau from 0.1% to 100% of the image."
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


def _removals(defence: Defence) -> str:
    lists = [("point", defence.points_that_matter), ("group", defence.groups_that_matter)]
    parts = []
    for kind, found in lists:
        if kind == "group" and defence.group_source is None:
            continue
        if not found:
            parts.append(f"no single {kind}'s removal changes it")
            continue
        shown = [
            f"without {kind} {r.name}"
            + (f" ({r.size} points)" if kind == "group" else "")
            + f" order {r.order} would win (ln B {r.log_bayes_factor:.1f})"
            for r in found[:4]
        ]
        more = f" and {len(found) - 4} more" if len(found) > 4 else ""
        parts.append(", ".join(shown) + more)
    if not parts:
        return ""
    joined = "; ".join(parts)
    return joined[0].upper() + joined[1:] + "."


def _disagreement(verdict: AxisVerdict, n: int) -> str:
    if verdict.aicc_order is None or verdict.aicc_order == verdict.bic_order:
        return ""
    return (
        f"AICc and BIC disagree because BIC asks ln n = {math.log(n):.1f} of twice the log "
        "likelihood for each coefficient, AICc little more than 2."
    )


def _leave_one_out(order: int, prediction: dict[int, Prediction]) -> str:
    if order not in prediction or len(prediction) == 1:
        return ""
    best = max(prediction, key=lambda k: prediction[k].loo.elpd)
    if best == order:
        rest = [k for k in prediction if k != order]
        runner = max(rest, key=lambda k: prediction[k].loo.elpd)
        found = prediction[runner]
        return (
            f"Leave-one-out agrees: order {runner} is next, by {-found.difference:.1f} "
            f"(SE {found.difference_se:.1f})."
        )
    found = prediction[order]
    ahead, se = -found.difference, found.difference_se
    similar = "; below 4, predictions are similar" if ahead < CLEAR_ELPD else ""
    return (
        f"Leave-one-out puts order {best} ahead by {ahead:.1f} (SE {se:.1f}{similar}): it asks "
        "only for prediction, the evidence also how much of the prior the data use up."
    )


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
