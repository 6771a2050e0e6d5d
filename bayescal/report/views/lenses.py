"""Lens models over many views as people see them: the verdict, and what it is worth."""

from __future__ import annotations

import math

from bayescal.calibration.error_model import ErrorModel
from bayescal.calibration.laplace import degrees
from bayescal.comparison.lenses.results import JudgedLens, LensComparison, Place
from bayescal.comparison.verdict import percent
from bayescal.report.blocks import Block, Blocks, Facts, Prose, Tabled, listed
from bayescal.report.table import Cell, Column, Table, number_cell
from bayescal.rounding import counted, rounded, significant

UNSOUND = "draws did not converge, or an evidence should not be trusted."
SHOWN = 12  # lenses
PRIORS = (
    "ln f about ln(width) sd 0.7, fy/fx sd 0.05, principal point sd 0.1 width about the middle; a "
    "coefficient by its displacement at the image's corner, N(0, (tau width)^2), tau inferred; "
    "poses uniform"
)


def brief(found: LensComparison) -> Blocks:
    """Everything that ``calibrate`` prints."""
    blocks: list[Block] = [
        *listed(about(found), "about"),
        Facts(tuple(assumed(found))),
        Tabled(
            "lenses",
            "Lens models, the most probable first.",
            lenses_table(found),
            tuple(lens_footnotes(found)),
        ),
        Prose(found.verdict.text, lead="Verdict"),
        *listed([f"{caveat}." for caveat in found.verdict.caveats], "caveat"),
        Tabled(
            "lens-parameters",
            f"Posterior of {found.best.key}.",
            parameters_table(found),
            (parameters_note(found),),
        ),
        Tabled(
            "lens-places",
            "How sure the projection is.",
            places_table(found),
            (places_note(found),),
        ),
        Prose(sampling_words(found), lead="Sampling"),
    ]
    if not found.sound:
        blocks.append(Prose(UNSOUND, lead="NOT SOUND"))
    return tuple(blocks)


def about(found: LensComparison) -> list[str]:
    """Say what was analysed."""
    views, setting = found.views, found.setting
    width, height = (int(v) for v in setting.data.size)
    kind = "planar target" if setting.data.planar else "target"
    line = (
        f"{views.source}: {counted(len(views), 'view')}, {counted(views.n_points, 'point')} of a "
        f"{kind} of {counted(len(views.target), 'point')}, image {width} by {height} px"
    )
    return [line, *(f"note: {note}" for note in found.notes)]


def assumed(found: LensComparison) -> list[tuple[str, str]]:
    """Name noise, errors and priors."""
    level, factor = found.setting.level.sigma, found.views.sigma is not None
    if level is None:
        what = "a factor on the stated deviations" if factor else "one sigma"
        noise = f"gaussian, {what} inferred, ln sigma uniform on 0.01 to 10 px"
    else:
        noise = f"gaussian, sigma {level:g}{' times those stated' if factor else ' px'}"
    if found.setting.grid.correlated or found.setting.grid.offsets:
        errors = f"settled before a lens is judged: {error_words(found)}"
    else:
        errors = "independent, the target exact (as asked for; no real target is)"
    bow = bow_words(found)
    pairs = [("noise", noise), ("errors", errors)]
    return [*pairs, *([("bow", bow)] if bow else []), ("priors", PRIORS)]


def error_words(found: LensComparison) -> str:
    """Error models averaged, in words."""
    weights = [weight for _, weight in found.errors]
    total = math.fsum(weights)

    def share(has: str) -> float:
        return math.fsum(w for e, w in found.errors if getattr(e, has) > 0) / total

    best = found.errors[0][0]
    sigma = _sigma(found)
    parts = []
    if found.setting.grid.correlated:
        parts.append(f"neighbours share errors: {percent(share('correlated'))}")
    if found.setting.grid.offsets:
        offsets = math.fsum(w for e, w in found.errors if e.offsets) / total
        parts.append(f"points of the target off: {percent(offsets)}")
    size = _shared_words(best, sigma)
    return "; ".join(parts) + (f" ({size})" if size else "")


def _shared_words(best: ErrorModel, sigma: float) -> str:
    parts = []
    if best.correlated:
        parts.append(f"shared sd {significant(sigma * best.correlated**0.5)} px")
    if best.offsets:
        size = sigma * math.hypot(best.rough, best.smooth)
        parts.append(f"offsets sd {significant(size)} px")
    return ", ".join([*parts, f"own sd {significant(sigma)} px"]) if parts else ""


def _sigma(found: LensComparison) -> float:
    problem = found.best.evidence.problem
    squares = problem.reduced.sum_of_squares
    known = problem.level.sigma
    return known if known is not None else math.sqrt(squares / degrees(problem.data))


def bow_words(found: LensComparison) -> str:
    """How much the target bows."""
    if not found.setting.bow:
        return ""
    x, y = (found.posterior[name] for name in ("bow_x", "bow_y"))
    return (
        f"of the target along x {rounded(x.mean, x.sd)} +- {significant(x.sd)}, along y "
        f"{rounded(y.mean, y.sd)} +- {significant(y.sd)} (its unit)"
    )


def lenses_table(found: LensComparison) -> Table:
    """Table of a row per lens."""
    known = found.setting.level.sigma is not None
    columns = [
        Column("lens", "what maps a ray to a pixel"),
        Column("order", "radial coefficients"),
        Column("K", "parameters: lens, six for each view, sigma where inferred"),
        Column("RMS", "distance of points from the least-squares fit, px"),
        *([Column("chi2", "weighted sum of squares")] if known else []),
        Column("dBIC", "above the smallest"),
        Column("ln Z", "log evidence, error models and poses averaged"),
        Column("+-", "its Monte Carlo error"),
        Column("P", "posterior probability, lenses equal before"),
        Column("elpd", "leave-one-view-out, nat"),
        Column("d elpd", "against the best, with its standard error"),
        Column("inside", "largest difference to the best where the points are, px"),
        Column("image", "the same over the image, px"),
    ]
    least = min(j.bic for j in found.lenses)
    rows = []
    for judged in found.lenses[:SHOWN]:
        lost = judged.left_out
        best = found.best.left_out
        gap = ""
        if lost is not None and best is not None and judged is not found.best:
            change = lost.log_density - best.log_density
            se = change.std(ddof=1) * len(change) ** 0.5
            gap = f"{change.sum():+.1f}±{se:.1f}"
        rows.append(
            (
                Cell(judged.key),
                number_cell(judged.candidate.order, lambda v: f"{v:.0f}"),
                Cell(str(judged.n_parameters), judged.n_parameters),
                number_cell(judged.rms, lambda v: f"{v:.4f}"),
                *([number_cell(judged.chi2, lambda v: f"{v:.0f}")] if known else []),
                number_cell(judged.bic - least, lambda v: f"{v:.1f}"),
                number_cell(judged.evidence.log_evidence, lambda v: f"{v:.2f}"),
                number_cell(judged.evidence.error, _error),
                Cell(percent(judged.probability), judged.probability),
                number_cell(None if lost is None else lost.elpd, lambda v: f"{v:.1f}"),
                Cell(gap),
                number_cell(judged.inside, _small),
                number_cell(judged.difference, _small),
            )
        )
    return Table(tuple(columns), tuple(rows), 0, True, ("elpd", "order", "image"))


def _error(value: float) -> str:
    return f"{value:.2f}" if value < 10 else "?"


def _small(value: float) -> str:
    return "-" if value == 0 else significant(value)


def lens_footnotes(found: LensComparison) -> list[str]:
    """Explain the columns."""
    lines = [
        "inside, image: largest difference of predictions to the best lens in px, where the points "
        "are and over the whole image, at infinity, after the turn that the poses absorb.",
        "elpd: leave-one-view-out, the pose of the view integrated; d elpd against the best, +- "
        "its paired standard error. dBIC counts poses, and takes noise as independent.",
    ]
    if found.impossible:
        lines.append(f"not possible, some point can't be seen: {', '.join(found.impossible)}.")
    if len(found.lenses) > SHOWN:
        rest = ", ".join(j.key for j in found.lenses[SHOWN:])
        lines.append(f"less probable, not shown: {rest} (--json has them).")
    return lines


def parameters_table(found: LensComparison) -> Table:
    """Posterior of the best lens."""
    columns = (
        Column("parameter"), Column("mean"), Column("sd"), Column("95% interval"),
        Column("at corner, px", "displacement it makes at the image's corner"),
        Column("ESS"), Column("R-hat"),
    )  # fmt: skip
    amplitudes = corner_displacements(found.best, found)
    rows = []
    for p in found.posterior.parameters:
        interval = " to ".join(rounded(end, p.sd) for end in p.interval)
        rows.append(
            (
                Cell(p.name),
                Cell(rounded(p.mean, p.sd), p.mean),
                Cell(significant(p.sd), p.sd),
                Cell(interval),
                Cell(amplitudes.get(p.name, "")),
                Cell(f"{min(p.ess_bulk, p.ess_tail):.0f}"),
                Cell(f"{p.rhat:.3f}"),
            )
        )
    return Table(columns, tuple(rows))


def corner_displacements(best: JudgedLens, found: LensComparison) -> dict[str, str]:
    """Displacement at the image's corner of each coefficient, mean and sd, px."""
    model = best.evidence.problem.model
    at = {name: j for j, name in enumerate(model.names)}
    grouped = {j for g in model.groups if g.name != "bow" for j in g.columns}
    out = {}
    for name, j in at.items():
        if j in grouped:
            values = found.draws[:, j]
            sd = float(values.std(ddof=1))
            out[name] = f"{rounded(float(values.mean()), sd)} +- {significant(sd)}"
    return out


def parameters_note(found: LensComparison) -> str:
    """Say what the table of parameters is of."""
    return (
        f"{found.best.key} under its most probable error model, by emcee; fx, fy, cx, cy and sigma "
        "in px, coefficients in OpenCV's order and sign; displacements: error models averaged."
    )


def places_table(found: LensComparison) -> Table:
    """How sure the projection is, at the centre and the worst of edges and corners."""
    columns = (
        Column("place"), Column("sd at infinity"), Column("sd at range"),
        Column("jackknife"), Column("halves"),
    )  # fmt: skip
    rows = []
    for name in ("centre", "edge", "corner"):
        group = [p for p in found.places if p.name.endswith(name)]
        worst = {
            column: _worst(group, column) for column in ("infinity", "near", "jackknife", "halves")
        }
        label = name if len(group) == 1 else f"{name}s, the worst"
        rows.append((Cell(label), *(number_cell(v, significant) for v in worst.values())))
    return Table(columns, tuple(rows))


def _worst(group: list[Place], column: str) -> float | None:
    known = [v for p in group if (v := getattr(p, column)) is not None]
    return max(known) if known else None


def places_note(found: LensComparison) -> str:
    """Say what the table of places shows."""
    return (
        "uncertainty of the projection in px (rms of r and c), the share of the poses taken out, "
        f"error models and probable lenses averaged; range {significant(found.range, 3)}, the "
        "target's distance. jackknife and halves: the same at infinity from the spread over views; "
        "where that is clearly larger, quote it."
    )


def sampling_words(found: LensComparison) -> str:
    """Say how the draws were made."""
    chain, estimate = found.posterior.chain, found.best.evidence.estimate
    n = chain.draws.shape[0] * chain.draws.shape[1]
    return (
        f"{found.best.key}: {n} draws by emcee, acceptance {chain.acceptance:.2f}; evidence from "
        f"{estimate.draws} importance draws, {100 * estimate.effective_fraction:.0f} % effective; "
        f"seed {found.request.seed}."
    )
