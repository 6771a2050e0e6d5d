"""Where the camera is: the posterior of its position beside the prior and the stated one."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.stats import norm

from bayescal.arrays import Array
from bayescal.comparison.families.result import JointModel
from bayescal.comparison.families.results import FamilyComparison
from bayescal.comparison.key import FREE
from bayescal.errors import InputError
from bayescal.prior.camera import PositionPrior, position_prior
from bayescal.report.figures.style import BLACK, CYCLE, DASHES, GREY, WIDTH, several_panels
from bayescal.report.typography import typeset
from bayescal.rounding import rounded

NAMES = ("position_x", "position_y", "position_z")
TAIL = 0.001  # of the draws on either side out of view
BINS = 50


def draw(found: FamilyComparison) -> Figure:
    """Draw a panel per coordinate; of every family the best model that was sampled."""
    models, prior = _models(found), position_prior(found.points)
    figure = several_panels(WIDTH, 2.9)
    panels = figure.subplots(1, 3)
    for i, panel in enumerate(panels):
        _coordinate(panel, i, models, prior)
    panels[0].set_ylabel("probability density [1 / world unit]")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=5)
    return figure


def _coordinate(panel: Axes, i: int, models: list[JointModel], prior: PositionPrior) -> None:
    stated, sd = float(prior.mean[i]), float(prior.sd[i])
    draws = [_draws(model)[:, i] for model in models]
    ends = np.quantile(np.concatenate(draws), [TAIL, 1 - TAIL]).tolist()
    low, high = min(stated, *ends), max(stated, *ends)
    margin = 0.06 * (high - low)
    low, high = low - margin, high + margin
    for k, (model, values) in enumerate(zip(models, draws, strict=True)):
        panel.hist(
            values,
            np.linspace(low, high, BINS + 1).tolist(),
            weights=np.full(len(values), BINS / (high - low) / len(values)),
            histtype="step",
            linewidth=1.4,
            label=f"{model.key.family} {model.key.order}",
            color=CYCLE[k],
            linestyle=DASHES[k % len(DASHES)],
        )
    x = np.linspace(low, high, 200)
    density = norm.pdf(x, stated, sd)
    panel.plot(x, density, color=GREY, linewidth=1, linestyle="-.", label="prior")
    panel.axvline(stated, color=BLACK, linewidth=1, label="stated")
    panel.set_xlim(low, high)
    panel.set_ylim(bottom=0)
    # A narrow range far from zero: few ticks, each in full.
    panel.locator_params(axis="x", nbins=3)
    panel.ticklabel_format(axis="x", useOffset=False)
    panel.set_xlabel(f"camera {'xyz'[i]} [world units]")
    panel.set_title(f"{'xyz'[i]}: {_found(models[0], i)}\nprior {_normal(stated, sd)}", loc="left")


def _models(found: FamilyComparison) -> list[JointModel]:
    """Give the most probable sampled model of each family at a free position."""
    out: dict[str, JointModel] = {}
    for model in found.models:
        if model.posterior is not None and model.key.position == FREE:
            out.setdefault(model.key.family, model)
    if not out:
        raise InputError("no model with a free camera position was sampled")
    return list(out.values())


def _draws(model: JointModel) -> Array:
    assert model.posterior is not None, "it was sampled"
    columns = [model.posterior.names.index(name) for name in NAMES]
    return model.posterior.chain.draws.reshape(-1, len(model.posterior.names))[:, columns]


def _found(model: JointModel, i: int) -> str:
    assert model.posterior is not None, "it was sampled"
    p = model.posterior[NAMES[i]]
    return typeset(f"{rounded(p.mean, p.sd)} ± {rounded(p.sd, p.sd)}")


def _normal(mean: float, sd: float) -> str:
    return typeset(f"N({mean:.5g}, {sd:.3g}²)")


def alt_text(found: FamilyComparison) -> str:
    """Say mean and sd of each model's coordinates, and the prior."""
    prior = position_prior(found.points)
    parts = [
        f"{model.key}: " + ", ".join(f"{'xyz'[i]} {_found(model, i)}" for i in range(3))
        for model in _models(found)
    ]
    stated = ", ".join(
        f"{'xyz'[i]} {_normal(float(prior.mean[i]), float(prior.sd[i]))}" for i in range(3)
    )
    return (
        f"Posterior of the camera position, world units, mean ± sd. {'; '.join(parts)}. Prior "
        f"about the stated position: {stated}."
    )
