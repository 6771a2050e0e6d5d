"""Every outlet of every kind of result says the same headline and the same caveats.

Truth: the document's own words, looked for in what a terminal, a page and a notebook show.
"""

from __future__ import annotations

import json
import re

import pytest

import bayescal as bc
from tests.helpers.command import here
from tests.helpers.page import read

EFFORT = ["--ess", "400"]
COMMANDS = {
    "families": ["compare", "--family", "separable,pinhole", "--orders", "1-2", "--position",
                 "stated", "--radial-orders", "0-1", *EFFORT],
    "robust": ["compare", "--noise", "student-t", "--axis", "c", "--orders", "1-2", *EFFORT],
    "defended": ["compare", "--defend", "--axis", "r", "--orders", "4", *EFFORT],
    "fit": ["fit", "--order-r", "3", "--order-c", "1", *EFFORT],
    "fit --family": ["fit", "--family", "pinhole", "--order", "1", *EFFORT],
    "outliers": ["outliers", "--axis", "c", "--orders", "1-2", *EFFORT],
    "lenses": ["calibrate", "--lens", "radial 1", "--lens", "radial 2"],
}  # fmt: skip


@pytest.fixture(scope="module", params=COMMANDS)
def told(request, tmp_path_factory) -> dict:
    """What each kind's document says; what is printed, and the result taken up again."""
    folder = tmp_path_factory.mktemp("kinds")
    done = here(*COMMANDS[request.param], "--out", folder / "run", "--json", folder / "it.json")
    assert done.code == 0, done.err
    document = json.loads((folder / "it.json").read_text(encoding="utf-8"))
    found = bc.open_run(folder / "run")
    bc.save_report(found, folder / "it.html")
    words = [read(page).words for page in ((folder / "it.html").read_text(), found._repr_html_())]
    parts = list(document.get("axes", {"": document}).values())
    verdicts = [v if isinstance(v := part["verdict"], str) else v["text"] for part in parts]
    findings = [part.get("findings") or part["verdict"]["findings"] for part in parts]
    return {
        "verdicts": verdicts,
        "said": [*verdicts, *(one["text"] for found in findings for one in found)],
        "printed": done.out,
        "result": found,
        "page": "".join(words[0]),
        "notebook": "".join(words[1]),
    }


def bare(text: str) -> str:
    """What is left without blanks and case: outlets break lines and typeset as they must."""
    signs = {"χ²": "chi2", "Δ elpd": "d elpd", "·": "*", "−": "-", "⁻": "-", "×": ""}  # noqa: RUF001
    for sign, plain in signs.items():
        text = text.replace(sign, plain)
    return re.sub(r"[\s^]", "", text).lower()


@pytest.mark.parametrize("outlet", ["printed", "page", "notebook"])
def test_every_outlet_says_it_all(told, outlet):
    shown = bare(told[outlet])
    assert [text for text in told["said"] if bare(text) not in shown] == []


def test_python_says_every_verdict(told):
    shown = bare(repr(told["result"]))
    assert [text for text in told["verdicts"] if bare(text) not in shown] == []
