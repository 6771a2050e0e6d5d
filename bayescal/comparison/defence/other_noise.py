"""The recommended order under other noise: whether the noise is what it was taken for."""

from __future__ import annotations

import math
from collections.abc import Sequence

from bayescal.comparison.evidence import strength
from bayescal.comparison.finding import limits
from bayescal.comparison.judged import Weighed
from bayescal.comparison.orders.axis import Axis
from bayescal.comparison.orders.candidates import order_of
from bayescal.comparison.orders.verdict import AxisVerdict
from bayescal.comparison.settings import Settings
from bayescal.comparison.store import Store
from bayescal.noise.choice import NOISE_MODELS, NOISE_WORDS, NoiseChoice
from bayescal.noise.model import NoiseModel
from bayescal.polynomials.axis_data import AxisData
from bayescal.rounding import significant

# 2 ln B above which another noise model is worth more than a bare mention (Kass & Raftery).
MENTION = 2.0
# Combined Monte Carlo errors that a difference must exceed to count.
ERRORS = 3.0


def other_noises(
    axis: Axis, own: NoiseModel, order: int, store: Store, settings: Settings
) -> tuple[Weighed, ...]:
    """Weigh an order under every noise model but its `own`."""

    def weigh() -> tuple[Weighed, ...]:
        others = [named(name, axis.data) for name in NOISE_MODELS if name != own.name]
        found = (order_of(axis, order, noise).beside(store, settings) for noise in others)
        return tuple(one.weighed for one in found)

    return store.once(f"{axis.data.axis} other noise", tuple[Weighed, ...], weigh)


def named(name: str, data: AxisData) -> NoiseModel:
    """Noise model of a name for some data, with its default priors."""
    return NoiseChoice(name).model(data.pixel)


def about_noise(verdict: AxisVerdict, own: Weighed, others: Sequence[Weighed]) -> AxisVerdict:
    """Add to a verdict whether `others`, of other noise, explain the data better."""
    if not others or verdict.order is None:
        return verdict
    text, caveat = noise_words(own, others)
    return verdict.with_findings(() if caveat is None else [limits("noise", caveat)], text)


def noise_words(own: Weighed, others: Sequence[Weighed]) -> tuple[str, str | None]:
    """Say how other noise compares with a candidate's own; and the caveat if one is better."""
    best = max(others, key=lambda one: _lead(one, own))
    lead, words = _lead(best, own), NOISE_WORDS[own.key.noise]
    error = math.hypot(best.log_evidence_error or 0.0, own.log_evidence_error or 0.0)
    if lead > MENTION / 2 and lead > ERRORS * error:
        doubt = " (an evidence that should not be trusted)" if best.warnings else ""
        return "", (
            f"{words} noise itself is a doubtful assumption: under {NOISE_WORDS[best.key.noise]} "
            f"noise these data are {_times(lead)} as probable, 2 ln B = {2 * lead:.1f}{doubt}, "
            f"{strength(lead)}; bayescal outliers says which points ask for it"
        )
    listed = " and ".join(
        f"{NOISE_WORDS[one.key.noise]} noise ({_lead(one, own):+.1f})" for one in others
    )
    return f"Other noise explains the data no better: ln B of {listed}.", None


def _lead(one: Weighed, other: Weighed) -> float:
    """Ln B of one candidate against another."""
    return (one.log_evidence or 0.0) - (other.log_evidence or 0.0)


def _times(log_factor: float) -> str:
    """Factor in words, of so many digits as matter."""
    if log_factor > math.log(1e4):
        return f"10^{log_factor / math.log(10):.0f} times"
    return f"{significant(math.exp(log_factor))} times"
