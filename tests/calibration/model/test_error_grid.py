"""The grid of error models: its prior, its neighbours, and the way it is followed."""

from __future__ import annotations

import math
from itertools import product

import numpy as np
import pytest
from scipy.special import logsumexp

from bayescal.calibration.model.error_grid import ErrorGrid, Node, carried_over, follow
from bayescal.calibration.model.error_model import ErrorModel, Geometry
from bayescal.calibration.model.observations import Observations
from tests.helpers import boards

GRIDS = [
    ErrorGrid(0.1),
    ErrorGrid(0.1, offsets=False),
    ErrorGrid(0.1, correlated=False, offsets=False),
]


def nodes(grid: ErrorGrid) -> list[Node]:
    """All nodes; without correlation there is no length."""
    everything = product(*map(range, grid.size))
    return [(c, n, r, s) for c, n, r, s in everything if c or n == 0]


@pytest.mark.parametrize("grid", GRIDS)
def test_the_prior_sums_to_one(grid: ErrorGrid) -> None:
    assert logsumexp([grid.log_prior(n) for n in nodes(grid)]) == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize("grid", GRIDS)
def test_every_node_is_reached_by_neighbours(grid: ErrorGrid) -> None:
    known = set(nodes(grid))
    reached, new = {(0, 0, 0, 0)}, {(0, 0, 0, 0)}
    while new:
        new = {other for node in new for other in grid.neighbours(node)} - reached
        assert new <= known
        reached |= new
    assert reached == known


@pytest.mark.parametrize("kept", [1.0, 5.0])
def test_following_a_hill_finds_its_sum(kept: float) -> None:
    """Truth: the sum over every node, of a broad hill far from the start."""
    grid = ErrorGrid(0.1)
    top = np.array([6, 3, 5, 2])

    def height(node: Node) -> float:
        return -0.6 * float(((np.array(node) - top) ** 2).sum())

    found = follow(grid, lambda nodes: list(map(height, nodes)), [(0, 0, 0, 0)], kept)
    truth = logsumexp([height(n) + grid.log_prior(n) for n in nodes(grid)])
    assert found.nodes[0] == tuple(top)
    assert found.log_evidence <= truth + 1e-12
    if kept == 5.0:
        assert found.log_evidence == pytest.approx(truth, abs=0.05)
        assert math.fsum(found.weights) > 0.95


def test_noise_of_a_view_is_that_of_its_points() -> None:
    """Truth: the covariance written out for a view that lacks points."""
    world, pixels = boards.pictures(np.random.default_rng(1), n_views=2)
    which = np.concatenate([np.arange(54), np.arange(0, 54, 3)])
    view = np.repeat([0, 1], [54, 18])
    seen = np.concatenate([pixels[0], pixels[1][::3]])
    data = Observations.of(world, which, seen, view, boards.SIZE)
    shared = Geometry(data).shared(ErrorModel(0.7, 0.2))
    assert shared.inverse is not None
    gap = np.linalg.norm(data.target[::3][:, None] - data.target[::3], axis=2)
    covariance = np.eye(18) + 0.7 * np.exp(-gap / 0.2)
    np.testing.assert_allclose(shared.inverse[1][:18, :18], np.linalg.inv(covariance), atol=1e-10)
    assert shared.log_dets[1] == pytest.approx(2 * np.linalg.slogdet(covariance)[1])
    alone = shared.only(np.array([1]), data.places_of(np.array([1])))
    assert alone.log_det == pytest.approx(shared.log_dets[1])


def test_noise_of_some_views_follows_points_left_out_in_their_midst() -> None:
    """Truth: the error model of those views by themselves."""
    world, pixels = boards.pictures(np.random.default_rng(1), n_views=3)
    data, error = boards.observed(world, pixels), ErrorModel(0.7, 0.2)
    out = np.zeros(data.seen.shape, dtype=bool)
    out[0, [3, 10]] = out[2, [0, 5, 30]] = True
    whole, some = data.without(out), np.array([2, 0])
    found = Geometry(whole).shared(error).only(some, whole.places_of(some))
    truth = Geometry(whole.only(some)).shared(error)
    assert found.inverse is not None
    assert truth.inverse is not None
    seen = whole.only(some).seen
    for ours, theirs, has in zip(found.inverse, truth.inverse, seen, strict=True):
        np.testing.assert_allclose(ours[has][:, has], theirs[has][:, has], atol=1e-9)
    np.testing.assert_allclose(found.log_dets, truth.log_dets, rtol=1e-12)


def test_offsets_have_the_stated_deviation() -> None:
    """Truth: rough within the plane alone; smooth on all axes, 1 at each point."""
    world, pixels = boards.pictures(np.random.default_rng(1), n_views=2)
    geometry = Geometry(boards.observed(world, pixels))
    for error, z in ((ErrorModel(rough=0.5), 0.0), (ErrorModel(smooth=0.5), 0.5)):
        root = geometry.offset_root(error, 0.01)
        assert root is not None
        sd = np.sqrt((root**2).sum(axis=1)).reshape(-1, 3) / 0.01
        np.testing.assert_allclose(sd[:, :2], 0.5, rtol=1e-3)
        np.testing.assert_allclose(sd[:, 2], z, rtol=1e-3)


@pytest.mark.parametrize(("drift", "alike"), [(0.05, True), (2.0, False)])
def test_error_models_are_taken_over_where_they_matter_alike(drift: float, alike: bool) -> None:
    """Truth: the sum over every node, of a hill and of one that a drift moves by little or more."""
    grid = ErrorGrid(0.1)

    def height(node: Node, drift: float = 0.0) -> float:
        return -0.6 * float(((np.array(node) - [6, 3, 5, 2]) ** 2).sum()) + drift * node[2] - 7

    like = follow(grid, lambda nodes: list(map(height, nodes)), [(6, 3, 5, 2)])
    found = carried_over(grid, lambda nodes: [height(n, drift) for n in nodes], like)
    assert (found is not None) == alike
    if found is not None:
        truth = logsumexp([height(n, drift) + grid.log_prior(n) for n in nodes(grid)])
        assert found.log_evidence == pytest.approx(truth, abs=0.05)
        weights = [math.exp(height(n, drift) + grid.log_prior(n) - truth) for n in found.nodes]
        assert found.weights == pytest.approx(weights, abs=0.01)
        assert found.tried < like.tried
