"""How far a command is: every step is counted once, and what is left follows from those done."""

from __future__ import annotations

import pytest

from bayescal.commands.shared.progress import Progress, time_left
from tests.helpers.command import here

QUICK = ("--quiet", "--ess", "100")


def test_time_left_is_at_the_pace_until_now() -> None:
    """Truth: 2 of 10 steps took 20 s, so that eight take 80 s, of which 5 have gone."""
    assert time_left(2, 10, 20.0, 25.0) == "0:01:15"
    assert time_left(1, 1000, 20.0, 20.0) == "5:33:00"
    assert time_left(0, 10, 0.0, 25.0) == "-:--:--"
    assert time_left(2, 3, 20.0, 100.0) == "0:00:00"


@pytest.mark.parametrize(
    "asked",
    [
        ("compare", "--family", "separable", "--orders", "1-2"),
        ("compare", "--family", "pinhole,bivariate", "--orders", "1-2", "--radial-orders", "0"),
        ("compare", "--orders", "1-2", "--axis", "r"),
    ],
)
def test_every_step_is_counted_once(
    asked: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    begun: list[int] = []
    totals: list[int] = []
    begin = Progress._begin

    def counted(self: Progress, words: str, weight: int) -> None:
        begun.append(weight)
        totals.append(self._total)
        begin(self, words, weight)

    monkeypatch.setattr(Progress, "_begin", counted)
    assert here(*asked, *QUICK).code == 0
    assert set(totals) == {sum(begun)}
