"""The verdict of one axis: the most probable order, how strong, which others stay."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

from bayescal.comparison.criteria.information import Criteria
from bayescal.comparison.evidence import plausible_set, strength
from bayescal.comparison.finding import Finding, ordered
from bayescal.comparison.orders.result import OrderResult
from bayescal.comparison.orders.sufficiency import Sufficiency
from bayescal.comparison.verdict import Verdict
from bayescal.noise.gaussian import GAUSSIAN
from bayescal.rounding import significant


@dataclass(frozen=True, kw_only=True, repr=False)
class AxisVerdict(Verdict):
    """What to conclude on one axis.

    Attributes
    ----------
    order : int or None
        The most probable order; None under a flat prior.
    plausible : tuple of int
        Smallest set of orders, by falling probability, that reaches 0.95.
    chances : tuple of float
        Probabilities of the plausible orders.
    log_bayes_factor_to_next : float or None
        ln B against the runner-up; None where one order was compared.
    strength : str or None
        Its strength in words (Kass & Raftery 1995).
    aicc_order, bic_order : int or None
        The orders that AICc (AIC where AICc is not defined) and BIC prefer.
    aic_name : str
        Which of the two it is, ``"AICc"`` or ``"AIC"``.
    findings, sentences : tuple
        As of `Verdict`.
    enough : Sufficiency or None
        How far the other plausible orders lie from the recommended one.
    """

    order: int | None
    plausible: tuple[int, ...]
    log_bayes_factor_to_next: float | None
    strength: str | None
    aicc_order: int | None
    bic_order: int | None
    enough: Sufficiency | None = None
    aic_name: str = "AICc"

    @property
    def outcome(self) -> str | None:
        """Decided, suffices, undecided or, where withheld, best compared; None without evidence."""
        if self.order is None:
            return None
        if self.withheld:
            return "best compared"
        if self.decided:
            return "decided"
        return "suffices" if self.enough is not None and self.enough.enough else "undecided"

    @property
    def recommended(self) -> str:
        """Name the recommended order."""
        return "no order" if self.order is None else f"order {self.order}"

    @property
    def others(self) -> str:
        """The other plausible orders with their probabilities; empty where there are none."""
        return f"{self._noun_of_others} {super().others}" if self.plausible[1:] else ""

    @property
    def standing(self) -> str:
        """How the recommended order stands, in a few words: what the headline says, shorter."""
        return "a flat prior has no evidence" if self.order is None else super().standing

    @property
    def headline(self) -> str:
        """The outcome in a sentence: decided, suffices, undecided, or the best compared."""
        if self.order is None:
            return "No order is recommended: a flat prior has no evidence."
        return super().headline

    @property
    def _noun_of_others(self) -> str:
        return "orders" if len(self.plausible) > 2 else "order"

    @property
    def not_excluded(self) -> str:
        """Which other orders are plausible; empty where none is."""
        return f"{self._named} not excluded" if self.others else ""

    @property
    def _named(self) -> str:
        return f"{self._noun_of_others} {', '.join(map(str, sorted(self.plausible[1:])))}"

    def _open_briefly(self) -> str:
        if self.enough is not None and self.enough.enough:
            return f"suffices: {self._named} within {self._size(self.enough.largest)}"
        return self.not_excluded

    def _open(self, lead: str, open_: str) -> str:
        enough = self.enough
        if enough is None:
            return super()._open(lead, open_)
        largest = self._size(enough.largest)
        whose = "as stated" if enough.stated else "a quarter of the noise"
        limit = f"the tolerance of {self._size(enough.tolerance)} ({whose})"
        if enough.enough:
            differ = "differ" if len(self.plausible) > 2 else "differs"
            return (
                f"{lead}, and suffices: {open_}, but {differ} from it by at most {largest} "
                f"anywhere (95%), within {limit}"
            )
        return (
            f"{lead}; undecided, and it matters: {open_}, and may differ from it by {largest} "
            f"somewhere (95%), above {limit}"
        )

    def _size(self, value: float) -> str:
        return significant(value) + (self.enough.suffix if self.enough else "")


def verdict_on(
    results: Sequence[OrderResult],
    findings: Sequence[Finding],
    enough: Callable[[tuple[int, ...]], Sufficiency | None] = lambda _: None,
) -> AxisVerdict:
    """Form the verdict of one axis from its orders, judged.

    Parameters
    ----------
    findings : sequence of Finding
        What limits it.
    enough : callable, optional
        From the plausible orders to how far they lie from the first.
    """
    evidence = {r.order: r.log_evidence for r in results if r.log_evidence is not None}
    chances = {r.order: r.probability for r in results if r.probability is not None}
    known = {r.order: r.criteria for r in results if r.key.noise == GAUSSIAN.name}
    verdict = judge(chances or None, evidence or None, known, findings)
    return replace(verdict, enough=enough(verdict.plausible)) if len(results) > 1 else verdict


def judge(
    probability: Mapping[int, float] | None,
    log_evidence: Mapping[int, float] | None,
    criteria: Mapping[int, Criteria],
    findings: Sequence[Finding],
) -> AxisVerdict:
    """Form the verdict of one axis.

    Parameters
    ----------
    probability, log_evidence : mapping of int to float or None
        By order; None under a flat prior.
    criteria : mapping of int to Criteria
        By order; empty where there are none, the noise not being Gaussian.
    findings : sequence of Finding
        What the comparison can't vouch for.
    """
    aic_name, aicc_order = _preferred_aic(criteria)
    bic_order = _smallest({k: c.bic for k, c in criteria.items()})
    by_criteria = _criteria_words(aic_name, aicc_order, bic_order)
    without = AxisVerdict(
        order=None,
        compared=len(criteria),
        plausible=(),
        chances=(),
        log_bayes_factor_to_next=None,
        strength=None,
        aicc_order=aicc_order,
        bic_order=bic_order,
        findings=ordered(findings),
        sentences=(by_criteria,),
        aic_name=aic_name,
    )
    if probability is None or log_evidence is None:
        return without
    order = max(probability, key=lambda k: (probability[k], -k))
    plausible = plausible_set(probability)
    rest = {k: z for k, z in log_evidence.items() if k != order}
    log_factor = log_evidence[order] - max(rest.values()) if rest else None
    words = strength(log_factor) if log_factor is not None else None
    sentences = []
    if log_factor is not None:
        runner_up = max(rest, key=lambda k: probability[k])
        sentences.append(
            f"Evidence against the runner-up, order {runner_up}: 2 ln B = {2 * log_factor:.1f}, "
            f"{words} (Kass & Raftery)."
        )
    if len(criteria) > 1:
        agree = aicc_order == bic_order == order
        sentences.append(f"{aic_name} and BIC agree." if agree else by_criteria)
    return replace(
        without,
        order=order,
        compared=len(probability),
        plausible=plausible,
        chances=tuple(probability[k] for k in plausible),
        log_bayes_factor_to_next=log_factor,
        strength=words,
        sentences=tuple(sentences),
    )


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
        return "AIC and BIC are unavailable: an order fits exactly."
    if aic_order == bic_order:
        return f"{aic_name} and BIC prefer order {aic_order}."
    return f"{aic_name} prefers order {aic_order}, BIC order {bic_order}."
