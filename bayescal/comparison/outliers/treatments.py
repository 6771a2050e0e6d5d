"""Ways of treating bad points, the orders under each, and whether they choose the order."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from scipy.special import logsumexp

from bayescal.comparison.defence.other_noise import ERRORS, MENTION
from bayescal.comparison.evidence import strength
from bayescal.comparison.judged import Judged
from bayescal.comparison.orders.result import OrderResult
from bayescal.noise.choice import NOISE_WORDS

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
    def sampled(self) -> tuple[OrderResult, ...]:
        """Orders that have draws: all of a robust noise model, else none."""
        return tuple(found for found in self.orders if isinstance(found, OrderResult))

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


def verdict_words(treatments: Sequence[Treatment]) -> str:
    """Say whether the choice of the order depends on the treatment; the first is Gaussian noise."""
    orders = {t.name: t.order for t in treatments}
    if len(set(orders.values())) == 1:
        text = f"Order {treatments[0].order} wins however bad points are treated"
    else:
        listed = ", ".join(f"{k} under {name}" for name, k in orders.items())
        text = f"The choice depends on how bad points are treated: order {listed}"
    return f"{text}. {_noise_words(treatments)} {_runners_up(treatments)}".strip()


def _runners_up(treatments: Sequence[Treatment]) -> str:
    """Name the orders that come second only where noise is not Gaussian."""
    gaussian, *others = treatments
    before = sorted(gaussian.log_evidence, key=lambda k: -gaussian.log_evidence[k])
    changed = []
    for t in others:
        values = t.log_evidence
        rest = [k for k in values if k != t.order]
        if not rest:
            continue
        second = max(rest, key=lambda k: values[k])
        if second != before[1]:
            gap = values[t.order] - values[second]
            changed.append(f"order {second}, {gap:.1f} nat behind, under {t.name}")
    return f"The runner-up changes: {'; '.join(changed)}." if changed else ""


def _noise_words(treatments: Sequence[Treatment]) -> str:
    """Say which noise model the data prefer, all orders taken together."""
    gaussian, *others = treatments
    best = max((t for t in others if t.n_points == gaussian.n_points), key=lambda t: t.total)
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
