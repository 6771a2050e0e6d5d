"""What stands against a verdict across families, or limits it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from bayescal.arrays import Array
from bayescal.comparison.adequacy.outcome import AdequacyTest
from bayescal.comparison.criteria.leave_one_out import paired_difference
from bayescal.comparison.families.result import JointModel
from bayescal.comparison.finding import Finding, limits, overturns
from bayescal.comparison.findings.bounds import PILE
from bayescal.comparison.findings.misfit import GRAVE, concerning, rejected
from bayescal.comparison.key import FREE, PINHOLE, STATED
from bayescal.density.pinholes.pinhole import PinholeModel
from bayescal.noise.level import sigma_bounds
from bayescal.points.correspondences import Correspondences
from bayescal.points.setup import AXES
from bayescal.polynomials import separable
from bayescal.prior.camera import position_prior
from bayescal.rounding import counted

FAR = 3.0  # standard deviations
MATTERS = 0.01  # least probability of a model whose faults limit the verdict


def family_findings(
    points: Correspondences, models: Sequence[JointModel], tests: Sequence[AdequacyTest] = ()
) -> list[Finding]:
    """Find what a reviewer should know of the verdict; the most probable model is the first.

    Parameters
    ----------
    tests : sequence of AdequacyTest, optional
        Of the most probable model's residuals.
    """
    found = [*_chi_squared(models[0]), *concerning(tests)]
    bounds = {f"sigma_{a}": sigma_bounds(separable.axis_pixel(points, a)) for a in AXES}
    for text in _at_bounds(models[0], bounds):
        found.append(overturns("sigma-bound", text, "sigma lies at a bound of its prior"))
    return [*found, *(limits("families", text) for text in _limits(points, models, bounds))]


def _chi_squared(best: JointModel) -> Iterator[Finding]:
    """Say where chi-squared rejects the most probable model at the known sigma."""
    good = best.goodness
    if good is None or good.p_value is None or good.p_value >= GRAVE:
        return
    yield rejected(str(best.key), f"{good.chi2_reduced:.3g}")


def _limits(
    points: Correspondences,
    models: Sequence[JointModel],
    bounds: Mapping[str, tuple[float, float]],
) -> list[str]:
    """Say what limits the verdict without standing against it."""
    best, matter = models[0], [m for m in models if (m.probability or 0.0) >= MATTERS]
    found: list[str] = []
    for model in matter:
        found += [f"the evidence of {model.key}: {warning}" for warning in model.warnings]
        found += _at_bounds(model, bounds) if model is not best else []
        if model.posterior is not None and not model.posterior.converged:
            found.append(f"sampling of {model.key} did not reach the stopping rule")
    found += _few_draws(matter)
    found += _displaced(points, matter)
    if best.camera is not None and best.posterior is not None:
        found += _far_optics(best.camera, best.posterior.full[:, -1])
    return [*found, *_default_priors(points, models), *_predicts_better(models)]


def _few_draws(models: Sequence[JointModel]) -> Iterator[str]:
    """Say whose leave-one-out rests on few draws."""
    heavy = [str(m.key) for m in models if m.loo is not None and (m.loo.largest_k or 0.0) > 1]
    if heavy:
        rest = f"; and of {counted(len(heavy) - 3, 'other')}" if len(heavy) > 3 else ""
        yield f"leave-one-out rests on few draws (Pareto k > 1) for {'; '.join(heavy[:3])}{rest}"


def _displaced(points: Correspondences, models: Sequence[JointModel]) -> Iterator[str]:
    """Say where the camera is found far from where it is stated."""
    free = next((m for m in models if m.key.position == FREE), None)
    if free is None:
        return
    prior = position_prior(points)
    shift = np.abs(free.position - prior.mean) / np.hypot(prior.sd, free.position_sd)
    if shift.max() > FAR:
        yield (
            f"the position found is {shift.max():.1f} sds, of prior and points together, from "
            "the stated one: prior and data disagree; AIC, BIC and chi-squared know no prior "
            "and are the found one's"
        )


def _default_priors(points: Correspondences, models: Sequence[JointModel]) -> Iterator[str]:
    """Say which priors are defaults that an evidence depends on."""
    pinholes = sum(m.probability or 0.0 for m in models if m.key.family == PINHOLE)
    if points.setup.camera.orientation_sd is None and 0.001 < pinholes < 0.999:
        # Three normal densities again; the polynomials take the orientation for exact.
        yield (
            "the evidence of the pinholes depends on the sd of their orientation's prior, which is "
            f"a default: half as wide could gain them up to {3 * math.log(2):.1f} nat; the setup's "
            "orientation_sd sets it"
        )
    if {m.key.position for m in models} == {STATED, FREE} and not position_prior(points).stated:
        # Three normal densities of twice the width are an eighth as high at the most.
        yield (
            "the evidence of a free position depends on its prior's sd, which is a default: "
            f"twice as wide would cost it up to {3 * math.log(2):.1f} nat; the setup's position_sd "
            "sets it"
        )


def _predicts_better(models: Sequence[JointModel]) -> Iterator[str]:
    """Say which model leave-one-out prefers to the most probable one, clearly."""
    best = models[0].loo
    if best is None or not best.reliable:
        return
    known = [(m.loo, m.key) for m in models if m.loo is not None and m.loo.reliable]
    ahead, name = max(known, key=lambda pair: pair[0].elpd)
    total, se = paired_difference(ahead, best)
    if total > max(4.0, 2 * se):
        yield f"leave-one-out prefers {name}, by {total:.1f} ± {se:.1f}"


def _at_bounds(model: JointModel, bounds: Mapping[str, tuple[float, float]]) -> list[str]:
    """Say which sigma is held by a bound of its prior rather than by the pixels."""
    out = []
    for name, masses in _masses_at_bounds(model, bounds):
        whys = "the pixels have hardly any noise", "the model does not fit"
        for bound, mass, why in zip(bounds[name], masses, whys, strict=True):
            if mass > PILE:
                share = f"{100 * mass:.0f}% of {name}'s posterior"
                out.append(f"{model.key}: {share} lies at its bound, {bound:.4g} px: {why}")
    return out


def _masses_at_bounds(
    model: JointModel, bounds: Mapping[str, tuple[float, float]]
) -> list[tuple[str, tuple[float, float]]]:
    """Give the posterior probability of each inferred sigma near its lower and upper bound, px."""
    posterior = model.posterior
    if posterior is None:
        known = zip(AXES, model.exact, strict=False)
        inferred = [(axis, e) for axis, e in known if e.model.noise.source == "inferred"]
        return [(f"sigma_{axis}", exact.sigma_at_bounds()) for axis, exact in inferred]
    sigmas = [name for name in posterior.names if name in bounds]
    return [(name, posterior.at_bounds(name, bounds[name])) for name in sigmas]


def _far_optics(model: PinholeModel, full: Array) -> list[str]:
    """Say which of a pinhole's focal length, principal point and rotation its prior doubts."""
    theta = model.coordinates(full).mean(axis=0)
    prior = model.prior
    offs = {
        "focal length": (theta[0] - math.log(prior.focal)) / prior.focal_log_sd,
        "principal point": np.abs((theta[2:4] - prior.centre) / prior.centre_sd).max(),
        "rotation": np.abs(theta[4:7] / prior.rotation_sd).max(),
    }
    where = "what the setup or its default expects"
    return [
        f"the {what} found is {abs(float(z)):.1f} prior sds from {where}: prior and data disagree"
        for what, z in offs.items()
        if abs(z) > FAR
    ]
