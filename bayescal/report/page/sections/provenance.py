"""Where the numbers come from, so that they can be had again."""

from __future__ import annotations

from typing import Any

from bayescal.report.facts import dumps
from bayescal.report.outliers import outliers_document
from bayescal.report.page.blocks import Block, Embedded, Facts, Prose, Section
from bayescal.report.page.subject import PageSubject


def section(subject: PageSubject) -> Section:
    """Show data, settings and versions, and keep the result document for machines."""
    found = subject.document
    data, settings, origin = found["data"], found["settings"], found["provenance"]
    chosen = {name: value for name, value in settings.items() if value is not None}
    blocks: list[Block] = [
        Facts(tuple((_words(k), _value(v)) for k, v in origin.items()), verbatim=True),
        Facts(tuple((_words(k), _value(v)) for k, v in data.items()), verbatim=True),
        Facts(tuple((_words(k), _value(v)) for k, v in chosen.items()), verbatim=True),
        Prose(
            "The result document below holds every number of this page, at full precision, for "
            "programs: JSON, schema " + str(found["schema"]) + "."
        ),
        _kept("result", found),
    ]
    if subject.study is not None:
        study = outliers_document(subject.study, str(origin["command"]))
        blocks += [
            Prose(f"The same of the bad points: JSON, schema {study['schema']}."),
            _kept("outliers", study),
        ]
    return Section(
        "provenance",
        "Provenance",
        "The same points, seed and versions give the same numbers.",
        tuple(blocks),
    )


def _kept(name: str, document: dict[str, Any]) -> Embedded:
    """Keep a document in the page; no text in it can end the element that holds it."""
    return Embedded(name, dumps(document).replace("<", "\\u003c"), f"{name}.json")


def _words(name: str) -> str:
    return {"sha256": "SHA-256", "n_points": "points"}.get(name, name.replace("_", " "))


def _value(value: Any) -> str:
    if isinstance(value, dict):
        return ", ".join(f"{_words(k)} {_value(v)}" for k, v in value.items())
    if isinstance(value, list):
        return ", ".join(map(_value, value)) or "nothing"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.10g}"
    return "not known" if value is None else str(value)
