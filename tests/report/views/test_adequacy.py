"""What a block of adequacy tests looks like in a terminal and in JSON."""

from __future__ import annotations

import io
import json

from rich.console import Console

from bayescal.comparison.adequacy.outcome import AdequacyTest
from bayescal.report.document.defence import adequacy_rows
from bayescal.report.terminal import laid_out
from bayescal.report.views.orders.adequacy import adequacy_blocks

PART = AdequacyTest("y/z", "F", 3.0, (1, 51), 0.02, "worth 1 px.")
TESTS = (
    AdequacyTest("chi2, known sigma", None, None, None, None, "sigma is not known"),
    AdequacyTest(
        "other coordinate", "F", 9.774, (3, 32), 1e-5, "[b]1 px[/b].", True, 2e-5, (PART,)
    ),
    AdequacyTest("runs along the regressor", "runs", 15.0, None, 0.42, "Fine.", False, 0.42),
    AdequacyTest("posterior predictive, largest |z|", "ppp", 0.07, None, None, "Fine."),
    AdequacyTest("shared errors in groups", "F", None, (3, 4), 0.0, "All of it.", True, 0.0),
)


def text(tests) -> str:
    console = Console(width=100, file=io.StringIO(), legacy_windows=False)
    with console.capture() as captured:
        console.print(laid_out(adequacy_blocks(tests, "r", 4)))
    return captured.get()


def test_rows_words_and_what_was_not_tested():
    shown = text(TESTS)
    lines = [" ".join(line.split()) for line in shown.splitlines()]
    assert "! other coordinate F = 9.77 3, 32 <0.001 <0.001" in lines
    assert "runs along the regressor runs = 15 0.420 0.420" in lines
    assert "! shared errors in groups F infinite 3, 4 <0.001 <0.001" in lines
    assert "1 px" not in shown  # the caveats of the verdict say it
    assert "Not tested: chi2, known sigma (sigma is not known)." in lines
    assert any("3 tests of this block" in line for line in lines)
    assert "not uniform" in shown
    assert max(map(len, shown.splitlines())) <= 100


def test_nothing_to_show_is_still_said():
    assert text(TESTS[:1]).strip() == "Not tested: chi2, known sigma (sigma is not known)."


def test_json_rows_keep_everything():
    rows = adequacy_rows(TESTS)
    assert json.loads(json.dumps(rows, allow_nan=False)) == rows
    assert rows[1] == {
        "name": "other coordinate",
        "statistic": "F",
        "value": 9.774,
        "dof": [3, 32],
        "p_value": 1e-5,
        "p_adjusted": 2e-5,
        "concern": True,
        "meaning": "[b]1 px[/b].",
        "parts": adequacy_rows((PART,)),
    }
