"""The corner plot: what its contours enclose, counted in draws of emcee."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.contour import QuadContourSet

from bayescal.report.figures.corner_plot import LEVELS
from bayescal.report.figures.registry import KINDS
from bayescal.report.figures.style import VERMILLION


@pytest.fixture(scope="module")
def corner(thesis_comparison):
    """Panels of r's order 2, and its draws with tau as log10."""
    posterior = thesis_comparison.axes["r"][2].posterior
    figure = KINDS["corner"].draw(thesis_comparison, "r", 2)
    size = len(posterior.names)
    draws = posterior.chain.draws.reshape(-1, size).copy()
    draws[:, posterior.names.index("tau")] = np.log10(draws[:, posterior.names.index("tau")])
    return np.array(figure.axes).reshape(size, size), draws, posterior.names


def closed_form(panel):
    (found,) = [
        artist
        for artist in panel.collections
        if isinstance(artist, QuadContourSet)
        and {to_hex(colour) for colour in artist.get_edgecolor()} == {VERMILLION}
    ]
    return found


def test_closed_form_contours_enclose_their_share_of_the_draws(corner):
    panels, draws, names = corner
    for j in range(len(names)):
        for i in range(j):
            contours = closed_form(panels[j, i])
            shares = [
                np.mean(path.contains_points(draws[:, [i, j]])) for path in contours.get_paths()
            ]
            for share, level in zip(shares, sorted(LEVELS, reverse=True), strict=True):
                # Binomial error of the draws, and 1 % for the mesh.
                error = np.sqrt(level * (1 - level) / len(draws))
                assert abs(share - level) < 4 * error + 0.01, (names[i], names[j])


def test_diagonals_hold_the_histogram_and_the_closed_form(corner):
    panels, draws, names = corner
    for j, name in enumerate(names):
        (curve,) = [a for a in panels[j, j].lines if to_hex(a.get_color()) == VERMILLION]
        x, density = curve.get_data()
        steps = np.diff(x)
        cumulative = np.concatenate([[0], np.cumsum(steps * (density[1:] + density[:-1]) / 2)])
        for probability in (0.1, 0.5, 0.9):
            at = np.interp(probability, cumulative, x)
            share = np.mean(draws[:, j] < at)
            error = np.sqrt(probability * (1 - probability) / len(draws))
            assert abs(share - probability) < 4 * error + 0.002, name
        lines = [a.get_xdata()[0] for a in panels[j, j].lines if a.get_linestyle() == "--"]
        np.testing.assert_allclose(lines, np.quantile(draws[:, j], [0.025, 0.5, 0.975]))


def test_corner_says_means_and_deviations(thesis_comparison):
    described = KINDS["corner"].alt_text(thesis_comparison, "r", 4)
    assert "alpha_0 986.6" in described or "alpha_0 986.5" in described
    assert "closed form" in described
