"""A fleet of cameras as people see it: which are odd, which failed, and the fleet's spread."""

from __future__ import annotations

from collections import Counter

import numpy as np

from bayescal.fleets.fleet import Fleet
from bayescal.fleets.odd import FAR, FEWEST, LEVEL, Oddity, Spread, score_limit, unit_of
from bayescal.fleets.record import LENS
from bayescal.report.blocks import Blocks, Details, Listing, Part, Prose, Section, Tabled, listed
from bayescal.report.table import Cell, Column, Table, number_cell
from bayescal.rounding import counted, rounded, significant

SHOWN = 20  # cameras of a list in a terminal
REASONS = 2  # of each odd camera, the gravest; the table has all


def brief(fleet: Fleet) -> Blocks:
    """Everything that ``fleet`` prints."""
    return (
        Listing(tuple(about(fleet)), "about"),
        *(Part(models_title(of), (models(fleet, of),)) for of in fleet.choices),
        *((Part("The fleet's spread", (spread(fleet),)),) if fleet.spreads else ()),
        Part("Odd cameras", odd(fleet, SHOWN)),
        *((Part("Not judged, or not soundly", wrong(fleet, SHOWN)),) if not fleet.sound else ()),
    )


def about(fleet: Fleet) -> list[str]:
    """Say how many cameras were judged, and how many of them are worth a look."""
    judged = len(fleet.records)
    line = f"{counted(len(fleet), 'camera')}: {judged} judged"
    if fleet.taken:
        line += f" ({fleet.taken} of them before)"
    parts = [line, f"{len({o.camera for o in fleet.odd})} odd"]
    parts += [f"{len(fleet.failed)} failed"] if fleet.failed else []
    parts += [f"{len(fleet.unsound)} not sound"] if fleet.unsound else []
    return [", ".join(parts)]


def models_title(of: str) -> str:
    """Head what was chosen."""
    return "Lens" if of == LENS else f"Order of {of}"


def models(fleet: Fleet, of: str) -> Tabled:
    """Count the cameras for which each model is recommended, decided, plausible."""
    choices = list(fleet.choices[of].values())
    best = Counter(c.model for c in choices)
    decided = Counter(c.model for c in choices if c.outcome == "decided")
    plausible = Counter(model for c in choices for model in c.plausible)
    known = sorted({*best, *plausible}, key=lambda m: (len(m), m) if of != LENS else (-best[m], m))
    rows = tuple(
        (Cell(model), *(_count(counts[model]) for counts in (best, decided, plausible)))
        for model in known
    )
    columns = (
        Column("lens" if of == LENS else "order"),
        Column("best", "cameras for which it is recommended"),
        Column("decided", "of them those where nothing else is plausible"),
        Column("plausible", "cameras that can't exclude it at 95%"),
    )
    common = known.index(fleet.common[of])
    return Tabled(
        f"models-{of}",
        f"{models_title(of)}: for how many of {counted(len(choices), 'camera')}.",
        Table(columns, rows, marked=common),
    )


def _count(number: int) -> Cell:
    return Cell(str(number), number)


def spread(fleet: Fleet) -> Tabled:
    """Show every quantity's median and spread over the fleet."""
    limit = score_limit(fleet.spreads)
    columns = (
        Column("quantity"),
        Column("median"),
        Column("sd", "over the fleet, which odd cameras do not widen; of sigma by its logarithm"),
        Column("own sd", "median of the cameras' own standard deviations"),
        Column("lowest"),
        Column("highest"),
        Column("odd", "cameras further from the median than chance explains"),
    )
    rows = tuple(_row(s, limit) for s in fleet.spreads)
    common = ", ".join(f"{of}: {model}" for of, model in fleet.common.items())
    note = (
        f"Parameters of the model recommended most often ({common}), whatever a camera's own; "
        "sigma: of the residuals of its own."
    )
    return Tabled("spread", "Every quantity over the fleet.", Table(columns, rows), (note,))


def _row(s: Spread, limit: float) -> tuple[Cell, ...]:
    known = s.sds[np.isfinite(s.sds)]
    own = float(np.median(known)) if len(known) else None
    unit = s.scale or own or abs(s.median) / 100 or 1.0
    values = (s.median, float(s.values.min()), float(s.values.max()))
    median, low, high = (Cell(rounded(v, unit), v) for v in values)
    far = int((np.abs(s.scores) > limit).sum())
    sds = [number_cell(v, lambda x: significant(x)) for v in (s.scale, own)]
    unit_name = unit_of(s.name)
    name = f"{s.of}: {s.name}{',' if unit_name else ''}{unit_name}"
    return (Cell(name), median, *sds, low, high, _count(far))


def odd(fleet: Fleet, most: int | None = None) -> Blocks:
    """List odd cameras and why, the oddest first."""
    limit = score_limit(fleet.spreads)
    by_camera: dict[str, list[Oddity]] = {}
    for one in fleet.odd:
        by_camera.setdefault(one.camera, []).append(one)
    if not by_camera:
        return (Prose(f"None. {_rule(limit)}"),)
    lines = [f"{camera}: {_reasons(why)}" for camera, why in by_camera.items()][:most]
    rest = len(by_camera) - len(lines)
    more = [f"{rest} more stand in cameras.parquet and on the page"] if rest else []
    return (*listed([*lines, *more]), Prose(_rule(limit)))


def _reasons(why: list[Oddity]) -> str:
    words = [f"{one.text} (score {_score(one.score)})" for one in why[:REASONS]]
    rest = len(why) - len(words)
    return "; ".join([*words, *([counted(rest, "further reason")] if rest else [])])


def _rule(limit: float) -> str:
    if limit == float("inf"):
        return f"Fewer than {FEWEST} cameras have no spread to be measured by."
    return (
        f"Odd: more than {limit:.1f} standard deviations of the fleet from its median (the score), "
        f"or the fleet's order or lens excluded. At most {LEVEL:.0%} of fleets without odd cameras "
        "show one."
    )


def _score(score: float) -> str:
    return f"{score:.1f}" if score < FAR else f"over {FAR:g}"


def wrong(fleet: Fleet, most: int | None = None) -> Blocks:
    """Name cameras that could not be judged, or not soundly."""
    lines = [f"{m.name}: {m.error}" for m in fleet.failed]
    lines += [f"{m.name}: not sound; look at it alone" for m in fleet.unsound]
    rest = len(lines[most:]) if most is not None else 0
    return listed([*lines[:most], *([f"{rest} more in cameras.parquet"] if rest else [])])


def every(fleet: Fleet) -> Blocks:
    """Show a row for every camera that was judged."""
    strange = {o.camera for o in fleet.odd}
    heads = [Column("camera"), Column("points")]
    for of in fleet.choices:
        name = of if of == LENS else f"order of {of}"
        heads += [Column(name), Column("probability"), Column("outcome"), Column("sigma, px")]
    rows: list[tuple[Cell, ...]] = []
    flagged = set()
    for name, record in fleet.records.items():
        cells = [Cell(name), Cell(str(record.n_points), record.n_points)]
        for of in fleet.choices:
            choice = fleet.choices[of].get(name)
            if choice is None:
                cells += [Cell("")] * 4
                continue
            chance = choice.probability.get(choice.model)
            cells += [
                Cell(choice.model),
                number_cell(chance, lambda p: f"{p:.3f}"),
                Cell(choice.outcome or ""),
                number_cell(choice.sigma.value, lambda s: significant(s, 3)),
            ]
        if name in strange:
            flagged.add(len(rows))
        rows.append(tuple(cells))
    shown = Tabled(
        "cameras",
        "Every camera that was judged; odd ones are marked.",
        Table(tuple(heads), tuple(rows)),
        flagged=frozenset(flagged),
    )
    return (Details(f"All {counted(len(rows), 'camera')}", (shown,)),)


def sections(fleet: Fleet) -> list[Section]:
    """Give the chapters of the page that need no figure."""
    chosen = tuple(Part(models_title(of), (models(fleet, of),)) for of in fleet.choices)
    found = [
        Section("odd", "Odd cameras", "Which cameras are not like the others?", odd(fleet)),
    ]
    if not fleet.sound:
        lead = "Which cameras could not be judged, and why."
        found.append(Section("wrong", "Not judged, or not soundly", lead, wrong(fleet)))
    if chosen:
        lead = "Which order or lens the cameras need."
        found.append(Section("models", "Models", lead, (*chosen, *every(fleet))))
    return found
