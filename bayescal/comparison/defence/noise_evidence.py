"""Evidence of the same orders under different noise models: whether the noise is Gaussian."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

from scipy.special import logsumexp

from bayescal.comparison.defence.defence import Defence
from bayescal.comparison.evidence import probabilities, strength
from bayescal.comparison.key import Key
from bayescal.comparison.results import AxisComparison
from bayescal.comparison.settings import Settings
from bayescal.comparison.store import Store
from bayescal.comparison.verdict import AxisVerdict
from bayescal.density.robust_linear import RobustLinearModel
from bayescal.inference.sampled_posterior import SampledPosterior, sample_model
from bayescal.linear.closed_form import exact_posterior
from bayescal.linear.least_squares import factorise
from bayescal.linear.model import LinearModel
from bayescal.noise.choice import NOISE_MODELS, NoiseChoice
from bayescal.noise.gaussian import Gaussian
from bayescal.noise.level import NoiseLevel
from bayescal.noise.model import NoiseModel
from bayescal.polynomials.axis_data import AxisData
from bayescal.prior.amplitudes import PriorRule
from bayescal.rounding import significant

# 2 ln B above which another noise model is worth more than a bare mention (Kass & Raftery).
MENTION = 2.0
# Combined Monte Carlo errors that a difference must exceed to count.
ERRORS = 3.0


@dataclass(frozen=True, eq=False)
class NoiseEvidence:
    """Log evidence of orders under one noise model.

    Attributes
    ----------
    name : str
        Of the noise model.
    log_evidence, error : dict of int to float
        By order, nat; the error of a closed form counts as 0.
    warnings : dict of int to tuple of str
        Why an evidence should not be trusted, by order; only those that should not.
    posteriors : dict of int to SampledPosterior
        By order; empty where the evidence has a closed form.
    """

    name: str
    log_evidence: dict[int, float]
    error: dict[int, float]
    warnings: dict[int, tuple[str, ...]]
    posteriors: dict[int, SampledPosterior]

    @property
    def probability(self) -> dict[int, float]:
        """Posterior probability of each order under this noise."""
        chances = probabilities(list(self.log_evidence.values()))
        return dict(zip(self.log_evidence, chances, strict=True))

    @property
    def order(self) -> int:
        """The most probable order under this noise."""
        return max(self.log_evidence, key=lambda k: (self.log_evidence[k], -k))

    @property
    def total(self) -> float:
        """Log evidence of the noise model, orders equally probable beforehand."""
        values = list(self.log_evidence.values())
        return float(logsumexp(values)) - math.log(len(values))

    @property
    def total_error(self) -> float:
        """Monte Carlo error of `total`, nat."""
        parts = [p * self.error[k] for k, p in self.probability.items()]
        return math.hypot(*parts)


def noise_evidence(
    data: AxisData,
    level: NoiseLevel,
    rule: PriorRule,
    noise: NoiseModel,
    orders: Sequence[int],
    settings: Settings,
    store: Store,
    *,
    beside: bool = True,
) -> NoiseEvidence:
    """Evidence of orders under a noise model: in closed form, or sampled.

    Parameters
    ----------
    data : AxisData
    level : NoiseLevel
    rule : PriorRule
        Proper.
    noise : NoiseModel
    orders : sequence of int
    settings : Settings
    store : Store
    beside : bool, optional
        Whether the models stand beside those compared.
    """
    if isinstance(noise, Gaussian):
        factors = factorise(data, max(orders))
        exact = {
            k: exact_posterior(
                LinearModel(factors, k, level, rule.of_order(k), data.symbol)
            ).log_integral
            for k in orders
        }
        return NoiseEvidence(noise.name, exact, dict.fromkeys(orders, 0.0), {}, {})
    posteriors = {}
    for k in orders:
        model = RobustLinearModel.of_order(data, k, level, rule.of_order(k), noise)
        key = Key.of_axis(data.axis, k, noise.name)
        sample = partial(sample_model, model, key.rng(settings.seed), settings.ess)
        posteriors[k] = store.posterior(key, model, sample, beside=beside)
    return from_posteriors(noise.name, posteriors)


def from_posteriors(name: str, posteriors: Mapping[int, SampledPosterior]) -> NoiseEvidence:
    """Collect the evidences of posteriors that were sampled already."""
    estimates = {k: p.estimate for k, p in posteriors.items()}
    return NoiseEvidence(
        name,
        {k: e.log_evidence for k, e in estimates.items()},
        {k: e.error for k, e in estimates.items()},
        {k: e.warnings for k, e in estimates.items() if e.warnings},
        dict(posteriors),
    )


def with_noises(
    axis: AxisComparison,
    defence: Defence,
    store: Store,
    settings: Settings,
) -> Defence:
    """Add the evidence of the recommended order under every other noise model.

    Parameters
    ----------
    axis : AxisComparison
    defence : Defence
    store : Store
    settings : Settings
    """
    order = axis.verdict.order
    # A flat prior has no evidence, and no spare point tells the shape of the noise.
    if order is None or axis.chosen.fit.dof <= 0:
        return defence
    known = store.noises(axis.data.axis)
    if known is None:
        others = [named(n, axis.data) for n in NOISE_MODELS if n != axis.noise_model.name]
        known = tuple(
            noise_evidence(axis.data, axis.noise, axis.prior, noise, [order], settings, store)
            for noise in others
        )
    return replace(defence, noises=known)


def named(name: str, data: AxisData) -> NoiseModel:
    """Noise model of a name for some data, with its default priors."""
    return NoiseChoice(name).model(data.pixel)


def about_noise(verdict: AxisVerdict, axis: AxisComparison, defence: Defence) -> AxisVerdict:
    """Add to a verdict whether other noise explains the data better.

    Parameters
    ----------
    verdict : AxisVerdict
    axis : AxisComparison
    defence : Defence
        With `noises`.
    """
    if not defence.noises or verdict.order is None:
        return verdict
    own, chosen = axis.noise_model.name, axis[verdict.order]
    value, error = chosen.log_evidence, chosen.posterior.log_evidence_error
    assert value is not None, "an order is recommended by its evidence"
    text, caveat = noise_words(own, value, defence.noises, error or 0.0)
    return replace(
        verdict,
        text=f"{verdict.text} {text}".strip(),
        caveats=verdict.caveats if caveat is None else (*verdict.caveats, caveat),
    )


def noise_words(
    own: str, value: float, others: Sequence[NoiseEvidence], error: float = 0.0
) -> tuple[str, str | None]:
    """Say how other noise models compare with the one used, and the caveat if one is better.

    Parameters
    ----------
    own : str
        Name of the noise model used.
    value : float
        Its log evidence.
    others : sequence of NoiseEvidence
        Of the same orders.
    error : float, optional
        Monte Carlo error of `value`, nat.

    Returns
    -------
    text : str
    caveat : str or None
    """
    best = max(others, key=lambda o: o.total)
    lead = best.total - value
    if lead > MENTION / 2 and lead > ERRORS * math.hypot(best.total_error, error):
        doubt = " (an evidence that should not be trusted)" if best.warnings else ""
        return "", (
            f"{in_words(own)} noise itself is a doubtful assumption: under {in_words(best.name)} "
            f"noise these data are {_times(lead)} as probable, 2 ln B = {2 * lead:.1f}{doubt}, "
            f"{strength(lead)}; bayescal outliers says which points ask for it"
        )
    listed = " and ".join(f"{in_words(o.name)} noise ({o.total - value:+.1f})" for o in others)
    return f"Other noise explains the data no better: ln B of {listed}.", None


def in_words(name: str) -> str:
    """Name of a noise model as it stands in a sentence."""
    return {"gaussian": "Gaussian", "student-t": "Student-t", "outlier-mixture": "mixture"}[name]


def _times(log_factor: float) -> str:
    """Factor in words, of so many digits as matter."""
    if log_factor > math.log(1e4):
        return f"10^{log_factor / math.log(10):.0f} times"
    return f"{significant(math.exp(log_factor))} times"
