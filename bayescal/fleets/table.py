"""A fleet as columns: a row per camera, for a data frame or a Parquet file."""

from __future__ import annotations

import io
import json
from collections.abc import Mapping, Sequence
from typing import Any

from bayescal.fleets.odd import SIGMA, Oddity, Spread
from bayescal.fleets.record import LENS, Choice, Member

# Ends of the names of columns of words; of those that are empty all through, the rest are numbers.
WORDS = ("error", "odd", "outcome")


def columns(
    members: Sequence[Member],
    choices: Mapping[str, Mapping[str, Choice]],
    spreads: Sequence[Spread],
    odd: Sequence[Oddity],
) -> dict[str, list[Any]]:
    """Columns by name, an entry per camera; None where there is none."""
    why: dict[str, list[str]] = {}
    for found_odd in odd:
        why.setdefault(found_odd.camera, []).append(found_odd.text)
    found: dict[str, list[Any]] = {
        "camera": [m.name for m in members],
        "file": [m.file for m in members],
        "status": [_status(m) for m in members],
        "error": [m.error or None for m in members],
        "odd": ["; ".join(why[m.name]) if m.name in why else None for m in members],
        "n_points": [m.record.n_points if m.record else None for m in members],
        "seed": [m.record.seed if m.record else None for m in members],
    }
    for of, own in choices.items():
        found.update(_chosen(of, [own.get(m.name) for m in members]))
    for spread in spreads:
        unit = "_px" if spread.name == SIGMA else ""
        values = dict(zip(spread.cameras, spread.values.tolist(), strict=True))
        sds = dict(zip(spread.cameras, spread.sds.tolist(), strict=True))
        scores = dict(zip(spread.cameras, spread.scores.tolist(), strict=True))
        name = f"{spread.of}_{spread.name}".replace(" ", "_")
        found[f"{name}{unit}"] = [values.get(m.name) for m in members]
        found[f"{name}_sd{unit}"] = [_finite(sds.get(m.name)) for m in members]
        found[f"{name}_score"] = [_finite(scores.get(m.name)) for m in members]
    return found


def _status(member: Member) -> str:
    if member.record is None:
        return "failed"
    return "done" if member.record.sound else "not sound"


def _chosen(of: str, choices: list[Choice | None]) -> dict[str, list[Any]]:
    """Columns of a choice."""
    order = of != LENS
    name = f"{of}_order" if order else of
    model = [None if c is None else int(c.model) if order else c.model for c in choices]
    return {
        name: model,
        f"{of}_probability": [None if c is None else c.probability.get(c.model) for c in choices],
        f"{of}_outcome": [None if c is None else c.outcome for c in choices],
        f"{of}_plausible": [None if c is None else list(c.plausible) for c in choices],
    }


def _finite(value: float | None) -> float | None:
    return None if value is None or value != value else value


def parquet_bytes(table: Mapping[str, list[Any]], told: Mapping[str, Any]) -> bytes:
    """Encode columns as Parquet, with metadata of JSON values; the same give the same bytes."""
    import pyarrow as pa
    from pyarrow import parquet

    arrays = {name: pa.array(values) for name, values in table.items()}
    for name, array in arrays.items():
        if pa.types.is_null(array.type):  # whether any camera has one does not change its type
            arrays[name] = array.cast(pa.string() if name.endswith(WORDS) else pa.float64())
    made = pa.table(arrays)
    made = made.replace_schema_metadata({k: json.dumps(v) for k, v in told.items()})
    stream = io.BytesIO()
    parquet.write_table(made, stream)
    return stream.getvalue()
