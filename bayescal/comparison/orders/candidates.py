"""Candidates of one axis: an order under Gaussian noise, or under noise without a closed form."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, partial
from typing import TYPE_CHECKING

from bayescal.comparison.criteria.goodness import (
    NO_REFERENCE,
    GoodnessOfFit,
    ReferenceSigma,
    goodness_of_fit,
)
from bayescal.comparison.criteria.information import Criteria, criteria, robust_criteria
from bayescal.comparison.judged import Judged, Weighed
from bayescal.comparison.key import Key
from bayescal.comparison.orders.axis import Axis
from bayescal.comparison.orders.result import OrderResult
from bayescal.comparison.settings import Settings
from bayescal.comparison.store import Store
from bayescal.inference.checked_posterior import sample_posterior
from bayescal.linear.closed_form import ExactPosterior, exact_posterior
from bayescal.linear.least_squares import LeastSquaresFit
from bayescal.linear.model import LinearModel
from bayescal.noise.model import NoiseModel

if TYPE_CHECKING:  # Gaussian noise does not pay for what it does not need
    from bayescal.comparison.criteria.leave_one_out import LeaveOneOut
    from bayescal.density.robust_linear import RobustLinearModel
    from bayescal.inference.posterior import Posterior
    from bayescal.inference.sampled_posterior import SampledPosterior


@dataclass(frozen=True, eq=False)
class _Order:
    """One order of an axis."""

    axis: Axis
    order: int
    noise: NoiseModel

    @property
    def key(self) -> Key:
        """Which it is."""
        return Key.of_axis(self.axis.data.axis, self.order, self.noise.name, self.axis.family)

    @cached_property
    def fit(self) -> LeastSquaresFit:
        """Least squares."""
        return self.axis.fit(self.order)

    def _result(
        self,
        posterior: Posterior,
        goodness: GoodnessOfFit,
        found: Criteria,
        loo: LeaveOneOut | None,
    ) -> OrderResult:
        return OrderResult(
            key=self.key,
            data=self.axis.data,
            log_evidence=posterior.log_evidence,
            log_evidence_error=posterior.log_evidence_error,
            warnings=posterior.warnings,
            posterior=posterior,
            loo=loo,
            fit=self.fit,
            rss_px2=self.axis.rss_px2(self.fit),
            goodness=goodness,
            criteria=found,
        )


@dataclass(frozen=True, eq=False)
class GaussianOrder(_Order):
    """One order under Gaussian noise: in closed form, and sampled.

    Attributes
    ----------
    reference : ReferenceSigma
        What chi-squared is measured in.
    """

    reference: ReferenceSigma = NO_REFERENCE

    @cached_property
    def model(self) -> LinearModel:
        """The likelihood and its prior."""
        return self.axis.linear(self.order)

    @cached_property
    def exact(self) -> ExactPosterior:
        """The closed form."""
        return exact_posterior(self.model)

    def left_out(self, store: Store, exact: ExactPosterior | None = None) -> LeaveOneOut | None:
        """Leave each point out, exactly; once, whatever `exact` was computed before."""

        def find() -> LeaveOneOut | None:
            from bayescal.comparison.criteria.leave_one_out import leave_one_out

            return leave_one_out(self.axis.data, exact or self.exact)

        return store.leave_one_out(self.key, find, ", exact")

    def beside(self, store: Store, settings: Settings) -> Judged:  # noqa: ARG002
        """Say what the closed form says, beside what is compared: without any draws."""
        return Judged(key=self.key, log_evidence=self.exact.log_integral, log_evidence_error=0.0)

    def judge(self, store: Store, settings: Settings) -> OrderResult:
        """Say what closed form and draws say of it."""
        axis, factors, held = self.axis, self.axis.factors, self.axis.data.whole is None
        sample = partial(sample_posterior, self.model, self.key.rng(settings.seed), settings.ess)
        posterior = store.posterior(self.key, self.model, sample)
        return self._result(
            posterior,
            goodness_of_fit(self.fit, axis.fit(axis.highest), self.reference),
            criteria(self.fit, axis.noise, factors.n, factors.log_sd),
            self.left_out(store, posterior.exact) if settings.defend and held else None,
        )


@dataclass(frozen=True, eq=False)
class RobustOrder(_Order):
    """One order under a noise model without a closed form: sampled.

    Chi-squared and the criteria are Gaussian and left empty; the least-squares fit stays, for
    comparison.
    """

    model: RobustLinearModel

    @classmethod
    def of(cls, axis: Axis, order: int, noise: NoiseModel) -> RobustOrder:
        """Build its density; refuse too few points, and a prior without an evidence."""
        from bayescal.density.robust_linear import RobustLinearModel

        prior = axis.prior(order)
        model = RobustLinearModel.of_order(axis.data, order, axis.noise, prior, noise)
        return cls(axis, order, noise, model)

    def posterior(
        self, store: Store, settings: Settings, *, beside: bool = False
    ) -> SampledPosterior:
        """Draws and the evidence from them; `beside` what is compared, a run need not have it."""
        from bayescal.inference.sampled_posterior import sample_model

        rng, ladder = self.key.rng(settings.seed), self.model.ladder
        draws = self.model.evidence_draws
        sample = partial(
            sample_model, self.model, rng, settings.ess, evidence_draws=draws, ladder=ladder
        )
        return store.posterior(self.key, self.model, sample, beside=beside)

    def beside(self, store: Store, settings: Settings) -> Weighed:  # noqa: ARG002
        """Say what its evidence is, beside what is compared: of weighted draws, where they fit."""
        from bayescal.inference.sampled_posterior import evidence_of

        rng, ladder = self.key.rng(settings.seed), self.model.ladder
        found = evidence_of(self.model, rng, settings.ess, ladder, self.model.evidence_draws)
        return Weighed(
            key=self.key,
            log_evidence=found.log_evidence,
            log_evidence_error=found.error,
            warnings=found.warnings,
        )

    def judge(self, store: Store, settings: Settings) -> OrderResult:
        """Say what its draws say."""
        from bayescal.comparison.criteria.psis import sampled_leave_one_out

        posterior, loo = self.posterior(store, settings), None
        if settings.defend:
            find = partial(sampled_leave_one_out, posterior, self.model.log_likelihood)
            loo = store.leave_one_out(self.key, find)
        return self._judged(posterior, loo)

    def _judged(self, posterior: SampledPosterior, loo: LeaveOneOut | None) -> OrderResult:
        goodness = GoodnessOfFit(None, self.fit.dof, None, None, None, None, None)
        return self._result(posterior, goodness, robust_criteria(posterior.names), loo)


def order_of(
    axis: Axis, order: int, noise: NoiseModel, reference: ReferenceSigma = NO_REFERENCE
) -> GaussianOrder | RobustOrder:
    """Make the candidate of an order under a noise model."""
    if noise.conjugate:
        return GaussianOrder(axis, order, noise, reference)
    return RobustOrder.of(axis, order, noise)
