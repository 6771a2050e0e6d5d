"""The verdict of one axis: the most probable order, how strong, which others stay."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from bayescal.comparison.criteria import Criteria
from bayescal.comparison.evidence import plausible_set, strength
from bayescal.comparison.order_result import OrderResult
from bayescal.markup import bullets, paragraph
from bayescal.noise.gaussian import GAUSSIAN


@dataclass(frozen=True)
class AxisVerdict:
    """What to conclude on one axis.

    Attributes
    ----------
    order : int or None
        The most probable order; None under a flat prior.
    plausible : tuple of int
        Smallest set of orders, by falling probability, that reaches 0.95.
    decided : bool
        Whether that set has one member.
    log_bayes_factor_to_next : float or None
        ln B against the runner-up; None where one order was compared.
    strength : str or None
        Its strength in words (Kass & Raftery 1995).
    aicc_order, bic_order : int or None
        The orders that AICc (AIC where AICc is not defined) and BIC prefer.
    aic_name : str
        Which of the two it is, ``"AICc"`` or ``"AIC"``.
    caveats : tuple of str
    text : str
        One paragraph.
    """

    order: int | None
    plausible: tuple[int, ...]
    decided: bool
    log_bayes_factor_to_next: float | None
    strength: str | None
    aicc_order: int | None
    bic_order: int | None
    caveats: tuple[str, ...]
    text: str
    aic_name: str = "AICc"

    def _repr_html_(self) -> str:
        """Show the verdict in a notebook."""
        return paragraph(self.text) + bullets("Caveats", self.caveats)


def verdict_on(results: Sequence[OrderResult], caveats: Sequence[str]) -> AxisVerdict:
    """Form the verdict of one axis from its orders, judged; `caveats` limit it."""
    evidence = {r.order: r.log_evidence for r in results if r.log_evidence is not None}
    chances = {r.order: r.probability for r in results if r.probability is not None}
    known = {r.order: r.criteria for r in results if r.key.noise == GAUSSIAN.name}
    return judge(chances or None, evidence or None, known, caveats)


def judge(
    probability: Mapping[int, float] | None,
    log_evidence: Mapping[int, float] | None,
    criteria: Mapping[int, Criteria],
    caveats: Sequence[str],
) -> AxisVerdict:
    """Form the verdict of one axis.

    Parameters
    ----------
    probability, log_evidence : mapping of int to float or None
        By order; None under a flat prior.
    criteria : mapping of int to Criteria
        By order; empty where there are none, the noise not being Gaussian.
    caveats : sequence of str
        What the comparison can't vouch for.
    """
    aic_name, aicc_order = _preferred_aic(criteria)
    bic_order = _smallest({k: c.bic for k, c in criteria.items()})
    by_criteria = _criteria_words(aic_name, aicc_order, bic_order)
    if probability is None or log_evidence is None:
        text = f"No order is recommended: a flat prior has no evidence. {by_criteria}"
        return AxisVerdict(
            None, (), False, None, None, aicc_order, bic_order, tuple(caveats), text, aic_name
        )
    order = max(probability, key=lambda k: (probability[k], -k))
    plausible = plausible_set(probability)
    decided = len(plausible) == 1
    rest = [z for k, z in log_evidence.items() if k != order]
    log_factor = log_evidence[order] - max(rest) if rest else None
    words = strength(log_factor) if log_factor is not None else None
    text = _text(order, probability, plausible, log_factor, words)
    agree = aicc_order == bic_order == order
    if len(criteria) <= 1:
        pass
    elif agree:
        text += f" {aic_name} and BIC agree."
    else:
        text += f" {by_criteria}"
    return AxisVerdict(
        order,
        plausible,
        decided,
        log_factor,
        words,
        aicc_order,
        bic_order,
        tuple(caveats),
        text,
        aic_name,
    )


def _text(
    order: int,
    probability: Mapping[int, float],
    plausible: tuple[int, ...],
    log_factor: float | None,
    words: str | None,
) -> str:
    if log_factor is None:
        return f"Order {order} is the only one compared."
    others = [k for k in plausible if k != order]
    runner_up = max((k for k in probability if k != order), key=lambda k: probability[k])
    text = f"Order {order} is the most probable, {percent(probability[order])}; "
    if others:
        listed = ", ".join(f"{k} ({percent(probability[k])})" for k in others)
        noun = "order" if len(others) == 1 else "orders"
        text += f"not decided: {noun} {listed} can't be excluded at 95%. "
    else:
        text += "decided at 95%. "
    return text + (
        f"Evidence against the runner-up, order {runner_up}: 2 ln B = {2 * log_factor:.1f}, "
        f"{words} (Kass & Raftery)."
    )


def percent(probability: float) -> str:
    """Probability in per cent with the digits that matter near 0 and 1."""
    value = 100 * probability
    if value > 99.95:
        return ">99.9%"
    if value < 0.05:
        return "<0.1%"
    return f"{value:.1f}%" if value < 10 or value > 90 else f"{value:.0f}%"


def _preferred_aic(criteria: Mapping[int, Criteria]) -> tuple[str, int | None]:
    """Find the order AICc prefers, or AIC where AICc is not defined for every order."""
    if all(c.aicc is not None for c in criteria.values()):
        return "AICc", _smallest({k: c.aicc for k, c in criteria.items()})
    return "AIC", _smallest({k: c.aic for k, c in criteria.items()})


def _smallest(values: Mapping[int, float | None]) -> int | None:
    known = {k: v for k, v in values.items() if v is not None}
    if not known or len(known) < len(values):  # an exact fit: nothing to weigh
        return None
    return min(known, key=lambda k: (known[k], k))


def _criteria_words(aic_name: str, aic_order: int | None, bic_order: int | None) -> str:
    if aic_order is None or bic_order is None:
        return "AIC and BIC can't be had: an order fits exactly."
    if aic_order == bic_order:
        return f"{aic_name} and BIC prefer order {aic_order}."
    return f"{aic_name} prefers order {aic_order}, BIC order {bic_order}."
