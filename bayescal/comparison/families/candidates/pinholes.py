"""Pinholes, whose pose is part of the model: every one is sampled."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.special import logsumexp

from bayescal.arrays import Array, frozen
from bayescal.comparison.criteria.information import Criteria
from bayescal.comparison.criteria.psis import Without
from bayescal.comparison.families.candidates.joint import Likelihood, judged_by
from bayescal.comparison.families.linearised import Linearised, of_pinhole
from bayescal.comparison.families.models import fitted_pinhole, gaussian_pinhole, robust_pinhole
from bayescal.comparison.families.request import FamilyRequest
from bayescal.comparison.families.result import JointModel
from bayescal.comparison.key import PINHOLE, Key
from bayescal.comparison.settings import Settings
from bayescal.comparison.store import Store
from bayescal.density.joint_data import JointData
from bayescal.density.pinholes.coordinates import position_sd
from bayescal.density.pinholes.gaussian import GaussianPinhole
from bayescal.density.pinholes.pinhole import PinholeModel
from bayescal.density.pinholes.proposal import ladder, weighted_evidence
from bayescal.inference.estimate import EvidenceEstimate
from bayescal.inference.proposals.laplace_mixture import mixture_about
from bayescal.inference.sampled_posterior import Guess, SampledPosterior, sample_model
from bayescal.points.correspondences import Correspondences

# Draws of the evidence without a point that leave-one-out from the draws fails for.
REFIT_DRAWS = 600


@dataclass(frozen=True, eq=False)
class PinholeCandidate:
    """One pinhole; as it stands, under noise without a closed form."""

    key: Key
    model: PinholeModel

    @property
    def count(self) -> int:
        """K: coefficients, inferred sigmas, shapes of the noise, and the pose."""
        model = self.model
        return sum(model.data.inferred) + 2 * model.noise.dimension + model.geometry.dimension

    @property
    def likelihood(self) -> Likelihood:
        """K alone: the likelihood may have no maximum."""
        return Likelihood(Criteria(self.count))

    def sample(self, rng: np.random.Generator, ess: int) -> SampledPosterior:
        """Sample it by a proposal adapted to its density."""
        return sample_model(self.model, rng, ess)

    def without(self, seed: int) -> Without | None:  # noqa: ARG002
        """Without a point it would have to be sampled anew."""
        return None

    def judge(self, store: Store, settings: Settings) -> JointModel:
        """Say what its draws say."""
        model, rng = self.model, self.key.rng(settings.seed)
        posterior = store.posterior(self.key, model, partial(self.sample, rng, settings.ess))
        place = model.geometry.position(model.geometry.full(model.fit.free[None]))[0]
        return judged_by(
            store,
            self.key,
            posterior,
            self.likelihood,
            model.log_likelihood,
            self.without(settings.seed),
            position=frozen(place),
            position_sd=position_sd(model.geometry, model.fit),
            residuals=model.fit.residuals,
            camera=model,
            pixels=model.data.pixels,
        )


@dataclass(frozen=True, eq=False)
class GaussianPinholeCandidate(PinholeCandidate):
    """One pinhole, whose sigmas and linear parameters are integrated out."""

    model: GaussianPinhole

    @property
    def likelihood(self) -> Likelihood:
        """That of the fit."""
        return Likelihood.of(self.model.data, self.model.fit.rss, self.count)

    def sample(self, rng: np.random.Generator, ess: int) -> SampledPosterior:
        """Sample it by Laplace approximations at a ladder of tau."""
        modes, log_mass = ladder(self.model)
        return sample_model(self.model, rng, ess, Guess(mixture_about(modes, log_mass), modes[:1]))

    @property
    def approximate(self) -> float:
        """Log evidence, by Laplace's approximation."""
        return float(logsumexp(ladder(self.model)[1]))

    def without_groups(self, members: Array) -> Array:
        """Give the same without each group, `members` ``(n_groups, n_points)``."""
        rest = [self.model.without(np.flatnonzero(group)) for group in members]
        return np.array([logsumexp(ladder(model)[1]) for model in rest])

    def linearised(self) -> Linearised:
        """About its highest likelihood."""
        return of_pinhole(self.model)

    def without(self, seed: int) -> Without:
        """Weigh draws of the other points' Laplace approximations."""

        def evidence(point: int) -> EvidenceEstimate:
            rng = self.key.rng(seed, point + 1)
            return weighted_evidence(self.model.without(point), rng, REFIT_DRAWS)

        return evidence


def pinholes(
    points: Correspondences,
    request: FamilyRequest,
    position: str,
    data: JointData,
    settings: Settings,
    store: Store,
) -> list[PinholeCandidate]:
    """List the pinholes of each order at one kind of position, fitted."""
    out: list[PinholeCandidate] = []
    for k in request.radial_orders:
        key = Key(PINHOLE, (k,), position, settings.noise)
        once = store.once_of(key)
        fitted = fitted_pinhole(points, k, position, request.radial, data, settings, once)
        if settings.choice.robust:
            model = robust_pinhole(fitted, settings.choice.model(1.0), once)
            out.append(PinholeCandidate(key, model))
        else:
            out.append(GaussianPinholeCandidate(key, gaussian_pinhole(fitted, once)))
    return out
