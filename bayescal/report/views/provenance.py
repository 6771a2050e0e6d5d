"""Where the numbers come from, so that they can be made again."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from bayescal.report.blocks import Block, Embedded, Facts, Prose, Section
from bayescal.report.document.shared import dumps


def section(documents: Mapping[str, dict[str, Any]]) -> Section:
    """Show where documents come from, as the first of them says, and keep them.

    Parameters
    ----------
    documents : mapping of str to dict
        Result documents by the names to keep them under.
    """
    found = next(iter(documents.values()))
    chosen = {name: value for name, value in found["settings"].items() if value is not None}
    blocks: list[Block] = [
        Facts(tuple((_words(k), _value(v)) for k, v in facts.items()), verbatim=True)
        for facts in (found["provenance"], found["data"], chosen)
    ]
    blocks.append(
        Prose(
            "What is kept below holds every number of this page, at full precision, for programs: "
            f"JSON, schema {' and '.join(str(d['schema']) for d in documents.values())}."
        )
    )
    blocks += [_kept(name, document) for name, document in documents.items()]
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
