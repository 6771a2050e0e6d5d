"""Least squares of any design: identities, refits, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import bayescal as bc
from bayescal.linear.design_fit import fit_design


def problem(seed: int, n: int = 12, p: int = 3):
    rng = np.random.default_rng(seed)
    return rng.normal(size=(n, p)), rng.normal(size=n)


@given(st.integers(0, 10**6), st.integers(1, 5))
def test_residuals_are_orthogonal_to_the_design_and_leverages_add_up_to_p(seed, p):
    design, t = problem(seed, p=p)
    fit = fit_design(design, t)
    assert np.abs(design.T @ fit.residuals).max() < 1e-12 * np.abs(design).max() * 12
    assert fit.residuals == pytest.approx(t - design @ fit.coefficients, abs=1e-9)
    assert fit.leverages.sum() == pytest.approx(p, abs=1e-12)
    assert fit.rss == pytest.approx(fit.residuals @ fit.residuals)
    assert (len(fit), fit.n_coefficients, fit.dof) == (12, p, 12 - p)


@given(st.integers(0, 10**6))
def test_scaling_a_column_scales_its_coefficient_and_nothing_else(seed):
    design, t = problem(seed)
    scale = np.array([1e-8, 1.0, 1e8])
    one, other = fit_design(design, t), fit_design(design * scale, t)
    assert other.residuals == pytest.approx(one.residuals, abs=1e-12)
    assert other.coefficients * scale == pytest.approx(one.coefficients, rel=1e-9)


def test_the_error_left_out_is_that_of_refits_without_each_point():
    design, t = problem(1)
    errors = []
    for i in range(len(t)):
        rest = np.delete(np.arange(len(t)), i)
        solution = np.linalg.lstsq(design[rest], t[rest], rcond=None)[0]
        errors.append(t[i] - design[i] @ solution)
    assert fit_design(design, t).rms_left_out == pytest.approx(np.sqrt(np.mean(np.square(errors))))


def test_a_point_that_alone_fixes_a_coefficient_can_not_be_left_out():
    design = np.column_stack([np.ones(6), [0, 0, 0, 0, 0, 1.0]])
    fit = fit_design(design, np.array([1.0, 2, 1, 2, 1, 9]))
    assert fit.leverages[-1] == pytest.approx(1)
    assert fit.rms_left_out is None


def test_exact_data_is_known_for_what_it_is():
    x = np.linspace(-1, 1, 9)
    design = np.column_stack([np.ones(9), x])
    assert fit_design(design, 3 + 2 * x).exact
    assert not fit_design(design, 3 + 2 * x + 1e-9 * (-1) ** np.arange(9)).exact


@pytest.mark.parametrize(
    ("design", "t", "complaint"),
    [
        (np.ones((3, 2)), np.ones(3), "1 of 2 coefficients"),
        (np.zeros((3, 1)), np.ones(3), "0 of 1 coefficients"),
        (np.ones((1, 2)), np.ones(1), "2 coefficients can't be found from 1 point;"),
        (np.ones((3, 1)), np.ones(2), "do not belong together"),
        (np.ones(3), np.ones(3), "do not belong together"),
        (np.ones((3, 0)), np.ones(3), "do not belong together"),
        (np.full((3, 1), np.nan), np.ones(3), "finite"),
        (np.ones((3, 1)), np.array([1, 2, np.inf]), "finite"),
    ],
)
def test_what_can_not_be_fitted_is_refused(design, t, complaint):
    with pytest.raises(bc.InputError, match=complaint):
        fit_design(design, t)
