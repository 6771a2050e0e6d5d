"""Corner plot of the lens: its draws, the error models averaged."""

from __future__ import annotations

from matplotlib.figure import Figure

from bayescal.arrays import Array
from bayescal.comparison.lenses.results import LensComparison
from bayescal.report.figures.corner_plot import check_spread, corner_plot, explain
from bayescal.rounding import rounded

BINS = 24  # fewer: there are fewer draws
PIXELS = ("f", "fx", "fy", "cx", "cy")  # parameters in px


def draw(found: LensComparison) -> Figure:
    """Draw every pair of the lens's parameters, and each alone with three quantiles."""
    names, draws = lens_draws(found)
    labels = [f"{name} [px]" if name in PIXELS else name for name in names]
    figure, _ = corner_plot(draws, labels, BINS)
    explain(figure, f"{found.best.name}, error models averaged", f"{len(draws)} draws")
    return figure


def lens_draws(found: LensComparison) -> tuple[tuple[str, ...], Array]:
    """Give names and draws of the lens's own parameters, the bow left out, ``(n_draws, n)``."""
    model, diagonal = found.problem.model, found.setting.data.diagonal
    kept = [j for j, name in enumerate(model.names) if not name.startswith("bow")]
    draws = model.report(found.draws, diagonal)[:, kept]
    names = tuple(model.names[j] for j in kept)
    check_spread(draws, names, found.best.name)
    return names, draws


def alt_text(found: LensComparison) -> str:
    """Say mean and sd of every parameter."""
    names, draws = lens_draws(found)
    parts = ", ".join(
        f"{name} {rounded(float(v.mean()), sd)} ± {rounded(sd, sd)}"
        for name, v in zip(names, draws.T, strict=True)
        for sd in [float(v.std(ddof=1))]
    )
    return f"Corner plot of {len(draws)} draws of {found.best.name}. Mean ± sd: {parts}."
