"""What the numerical tests share: comparisons of the thesis, sampled once."""

from __future__ import annotations

import pytest
from threadpoolctl import threadpool_limits

import bayescal as bc
from bayescal.comparison.results import Comparison


@pytest.fixture(scope="session", autouse=True)
def one_thread():
    """Small matrices gain nothing from threads and lose much where cores are shared."""
    with threadpool_limits(1):
        yield


@pytest.fixture(scope="session")
def thesis_comparison() -> Comparison:
    """Orders 1 to 5 of both axes of the thesis data, with every default."""
    return bc.compare(bc.thesis())


@pytest.fixture(scope="session")
def thesis_defended() -> Comparison:
    """The same with a defence."""
    return bc.compare(bc.thesis(), defend=True)


@pytest.fixture(scope="session")
def lens_comparison():
    """One lens over a few simulated views."""
    from tests.helpers.multi_view import lens_result

    return lens_result()
