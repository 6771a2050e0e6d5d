"""Single answers, asked alone, are those of a whole defence."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import bayescal as bc
from bayescal.comparison.alone import prediction_of, stability_of
from bayescal.comparison.results import Comparison


@pytest.fixture(scope="module")
def pair() -> tuple[Comparison, Comparison]:
    """The same comparison, plain and defended."""
    how = {"orders": [1, 2], "axis": "c", "ess": 100, "hint": False}
    plain, defended = bc.compare(bc.thesis(), **how), bc.compare(bc.thesis(), defend=True, **how)
    return plain, defended


def test_leave_one_out(pair: tuple[Comparison, Comparison]):
    plain, defended = pair
    wanted = defended["c"].defence.prediction
    found = prediction_of(plain, "c")
    assert list(found) == list(wanted)
    for order, one in wanted.items():
        np.testing.assert_array_equal(found[order].loo.pointwise, one.loo.pointwise)
        numbers = (found[order].difference, found[order].difference_se, found[order].group_elpd)
        assert numbers == (one.difference, one.difference_se, one.group_elpd)


def test_resamples_and_orders_beyond(pair: tuple[Comparison, Comparison]):
    plain, defended = pair
    resampled, beyond = stability_of(plain, "c")
    assert resampled == defended["c"].defence.resampled
    assert [one.unit for one in resampled] == ["point", "group"]
    assert beyond == defended["c"].defence.beyond


def test_nothing_where_there_is_nothing(pair: tuple[Comparison, Comparison]):
    """Without an evidence nothing can win; a sample of many points can't be left out."""
    flat = bc.compare(bc.thesis(), [1], axis="c", prior="flat", ess=100, hint=False)
    assert stability_of(flat, "c") == ((), None)
    with pytest.raises(bc.InputError, match="a flat prior none"):
        bc.plot(flat, "bootstrap")
    plain = pair[0]
    data = dataclasses.replace(plain["c"].data, whole=object())
    sample = dataclasses.replace(plain, axes={"c": dataclasses.replace(plain["c"], data=data)})
    assert prediction_of(sample, "c") == {}
    assert stability_of(sample, "c") == ((), None)
