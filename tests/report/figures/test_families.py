"""Figures of families show the numbers they are drawn of."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from matplotlib.collections import QuadMesh
from matplotlib.patches import Rectangle
from matplotlib.quiver import Quiver
from scipy.stats import norm

import bayescal as bc
from bayescal.comparison.families.results import FamilyComparison
from bayescal.density.pinholes.pinhole import PinholeModel
from bayescal.errors import InputError
from bayescal.report.figures.registry import KINDS
from bayescal.report.figures.style import figure_bytes
from tests.helpers.cameras import pixels
from tests.helpers.command import here

MINUS = "\N{MINUS SIGN}"


@pytest.fixture(scope="module")
def found(families_run: Path) -> FamilyComparison:
    return bc.open_run(families_run)


@pytest.fixture(scope="module")
def closed() -> FamilyComparison:
    """Models that all have a closed form."""
    return bc.compare_families(bc.thesis(), ["separable", "bivariate"], [1, 4])


def number(text: str) -> float:
    return float(text.replace(MINUS, "-"))


@pytest.mark.parametrize("which", ["found", "closed"])
def test_every_model_stands_in_the_cell_of_its_orders(
    which: str, request: pytest.FixtureRequest
) -> None:
    comparison = request.getfixturevalue(which)
    top = max(m.log_evidence for m in comparison.models)
    shown, framed = {}, []
    for panel in KINDS["models"].draw(comparison).axes:
        family, _, position = panel.get_title(loc="left").partition(", position ")
        down = [label.get_text() for label in panel.get_yticklabels()]
        across = [label.get_text() for label in panel.get_xticklabels()]
        frames = [p for p in panel.patches if isinstance(p, Rectangle) and not p.get_fill()]
        for text in panel.texts:
            j, i = (round(v) for v in text.get_position())
            order = f"({down[i]}, {across[j]})" if family == "separable" else across[j]
            shown[f"{family} {order}, position {position}"] = number(text.get_text())
            colour = panel.collections[0].get_array()
            assert isinstance(panel.collections[0], QuadMesh)
            value = colour[i, j]
            assert value == pytest.approx(number(text.get_text()), abs=0.051)
            for frame in frames:
                if frame.get_bbox().contains(j, i):
                    framed.append(f"{family} {order}, position {position}")
    assert framed == [str(comparison.best.key)]
    assert len(shown) == len(comparison.models)
    for model in comparison.models:
        assert shown[str(model.key)] == pytest.approx(model.log_evidence - top, abs=0.05)


def test_correlations_are_those_of_the_draws(found: FamilyComparison) -> None:
    (panel, _) = KINDS["correlation"].draw(found).axes
    posterior = found.best.posterior
    assert posterior is not None
    draws = posterior.chain.draws.reshape(-1, len(posterior.names))
    centred = draws - draws.mean(axis=0)
    covariance = centred.T @ centred
    sd = np.sqrt(np.diag(covariance))
    expected = covariance / np.outer(sd, sd)
    written = {tuple(map(round, t.get_position())): number(t.get_text()) for t in panel.texts}
    size = len(posterior.names)
    assert len(written) == size * (size - 1) // 2
    for (j, i), value in written.items():
        assert value == pytest.approx(expected[i + 1, j], abs=0.0051)
    labels = [t.get_text() for t in panel.get_yticklabels()]
    assert labels[0] == "focal c"
    assert labels[-2:] == [r"$\sigma$ r", r"$\sigma$ c"]
    words = KINDS["correlation"].alt_text(found)
    assert "centre_c and rotation_x +1.00" in words
    assert "Weakly identified together: " in words


def test_the_position_is_drawn_against_prior_and_statement(found: FamilyComparison) -> None:
    figure = KINDS["position"].draw(found)
    stated = bc.thesis().setup.position
    models = [found.best, next(m for m in found.models if m.key.family == "separable")]
    for i, panel in enumerate(figure.axes):
        prior, line = panel.lines
        assert set(line.get_xdata()) == {stated[i]}
        x, density = prior.get_data()
        sd = 93.9988  # a tenth of the median distance of the thesis's points
        assert density == pytest.approx(norm.pdf(x, stated[i], sd), rel=1e-4)
        outlines = [p for p in panel.patches if not isinstance(p, Rectangle)]
        for model, outline in zip(models, outlines, strict=True):
            corners = outline.get_xy()[1:-1:2]
            width = corners[1, 0] - corners[0, 0]
            edges, heights = corners[:-1, 0], corners[:-1, 1]
            column = model.posterior.names.index(f"position_{'xyz'[i]}")
            draws = model.posterior.chain.draws[..., column]
            assert (heights * width).sum() == pytest.approx(1, abs=0.005)  # 0.1 % out of view
            mean = (heights * width * (edges + width / 2)).sum()
            assert mean == pytest.approx(draws.mean(), abs=0.02 * draws.std() + 0.003 * abs(mean))
        assert "world units" in panel.get_xlabel()


def test_without_a_sampled_position_there_is_nothing_to_draw(closed: FamilyComparison) -> None:
    with pytest.raises(InputError, match="no model with a free camera position was sampled"):
        KINDS["position"].draw(closed)
    with pytest.raises(InputError, match="all have a closed form"):
        KINDS["correlation"].draw(closed)


def test_residuals_of_polynomials_are_those_of_their_sums(
    found: FamilyComparison, closed: FamilyComparison
) -> None:
    """Stated: the thesis's sums of squares. Free: the sums that the maximised likelihood has."""
    e = closed["separable (4, 1), position stated"].residuals
    assert (e**2).sum(axis=1) == pytest.approx([737.9, 644.7], abs=0.05)
    n = e.shape[1]
    for model in [*closed.models, *(m for m in found.models if m.key.family == "separable")]:
        rss = (model.residuals**2).sum(axis=1)
        maximised = -n / 2 * (np.log(2 * np.pi * rss / n) + 1).sum()
        assert maximised == pytest.approx(model.criteria.log_likelihood, abs=1e-6)


def test_residuals_of_a_pinhole_are_those_of_the_thesis_s_steps(found: FamilyComparison) -> None:
    model = found["pinhole 0, position free"]
    pinhole = model.posterior.model
    assert isinstance(pinhole, PinholeModel)
    theta = pinhole.geometry.full(pinhole.fit.free[None])[0].copy()
    points = found.points
    predicted = pixels(points.world, np.exp(theta[:2]), theta[2:4], theta[4:7], model.position)
    measured = np.column_stack([points.pixel(a) for a in "rc"])
    assert pytest.approx(measured - predicted, abs=1e-6) == model.residuals.T


def test_arrows_are_the_residuals_of_the_best_of_each_position(found: FamilyComparison) -> None:
    panels = KINDS["vectors"].draw(found).axes
    other = next(m for m in found.models if m.key.position == "stated")
    for panel, model in zip(panels, (found.best, other), strict=True):
        (arrows,) = (c for c in panel.collections if isinstance(c, Quiver))
        assert np.array([arrows.U, arrows.V]) == pytest.approx(model.residuals)
        assert str(model.key) in panel.get_title(loc="left")
        rms = np.sqrt((model.residuals**2).sum(axis=0).mean())
        assert f"{rms:.2f} px" in panel.get_title(loc="left")
    scales = {c.scale for p in panels for c in p.collections if isinstance(c, Quiver)}
    assert len(scales) == 1  # lengths compare across panels
    assert "16 (" in KINDS["vectors"].alt_text(found)


def test_one_position_is_one_panel(closed: FamilyComparison) -> None:
    assert len(KINDS["vectors"].draw(closed).axes) == 1


@pytest.mark.parametrize("kind", [k.name for k in KINDS.values() if k.of == "families"])
def test_the_command_draws_what_the_library_does(
    kind: str, found: FamilyComparison, families_run: Path, tmp_path: Path
) -> None:
    path = tmp_path / "made.svg"
    done = here("plot", kind, families_run, "--out", path)
    assert (done.code, done.err) == (0, "")
    assert path.read_bytes() == figure_bytes(bc.plot(found, kind), "svg")
    assert KINDS[kind].alt_text(found) in done.out


def test_the_library_says_what_it_can_draw(found: FamilyComparison) -> None:
    with pytest.raises(InputError, match="'curve' is no kind of figure of families; kinds: models"):
        bc.plot(found, "curve")
    with pytest.raises(InputError, match="leave out the axis"):
        bc.plot(found, "models", axis="r")
