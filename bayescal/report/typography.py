"""Text as a page shows it: true signs, and nothing that could reorder or hide it."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Callable

# Joiners that scripts need; other invisible characters are named instead of obeyed.
_KEPT = {"\u200c", "\u200d", "\u00ad"}
_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
# What the program's own words write in ASCII.
_SIGNS: tuple[tuple[re.Pattern[str], str | Callable[[re.Match[str]], str]], ...] = (
    (re.compile(r"(?<![\w.\-])-(?=\.?\d)"), "\N{MINUS SIGN}"),
    (re.compile(r"\bchi2\b"), "\N{GREEK SMALL LETTER CHI}\N{SUPERSCRIPT TWO}"),
    (re.compile(r"\bd(?=(?:AIC|AICc|BIC| elpd)\b)"), "\N{GREEK CAPITAL LETTER DELTA}"),
    (re.compile(r"^-$"), "\N{EN DASH}"),
    (re.compile(r"(?<=\d)±(?=\d)"), " ± "),
    (re.compile(r"(?<=\S) \* (?=\S)"), "\N{NO-BREAK SPACE}\N{MIDDLE DOT}\N{NO-BREAK SPACE}"),
    (re.compile(r"\b(?:alpha|beta)_\d+\b"), lambda found: symbol(found[0])),
    (re.compile(r"\bR-hat\b"), "R\u0302"),
    (re.compile(r"(?<=\d) x (?=\d)"), " \N{MULTIPLICATION SIGN} "),
    (
        re.compile(r"\bc = height - row\b"),
        "c\N{NO-BREAK SPACE}=\N{NO-BREAK SPACE}height\N{NO-BREAK SPACE}\N{MINUS SIGN}"
        "\N{NO-BREAK SPACE}row",
    ),
    (
        re.compile(r"(?<![\w.])(\d+(?:\.\d+)?)e(?:\+|(-))0*(\d+)\b"),
        "\\1\N{NO-BREAK SPACE}\N{MULTIPLICATION SIGN}\N{NO-BREAK SPACE}10^\\2\\3",
    ),
    (re.compile(r"\^(-?\d+)"), lambda found: found[1].translate(_SUPERSCRIPTS)),
    (re.compile(r"(?<=\d)%"), "\N{NARROW NO-BREAK SPACE}%"),
    (re.compile(r"(?<=\d) (?=(?:px|nat|%)(?!\w))"), "\N{NO-BREAK SPACE}"),
)
_LETTERS = {"alpha": "α", "beta": "β", "sigma": "σ", "tau": "τ", "nu": "ν"}  # noqa: RUF001
_SUBSCRIPTS = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")


def visible(text: str) -> str:
    """Name the characters that would hide, break or reorder the text around them.

    Bidirectional overrides, control characters and lone surrogates are shown as their
    code points; letters of every script, accents and emoji stay.
    """
    return "".join(
        f"[U+{ord(c):04X}]" if unicodedata.category(c)[0] == "C" and c not in _KEPT else c
        for c in text
    )


def typeset(text: str) -> str:
    """Give words that the program wrote in ASCII their signs, such as a true minus."""
    text = visible(text)
    for pattern, sign in _SIGNS:
        text = pattern.sub(sign, text)
    return text


def symbol(name: str) -> str:
    """Write a parameter such as ``alpha_2`` in Greek with a subscript, where it is one.

    What it is of may stand before it, and its unit behind it: ``r: alpha_2, px``.
    """
    of, colon, bare = name.rpartition(": ")
    bare, comma, unit = bare.partition(", ")
    if of or unit:
        return typeset(of) + colon + symbol(bare) + comma + typeset(unit)
    stem, _, index = name.partition("_")
    letter, space, rest = stem.partition(" ")
    if letter not in _LETTERS:
        return typeset(name)
    if index and not index.isdigit():  # of an axis
        return typeset(f"{_LETTERS[letter]} {index}")
    return _LETTERS[letter] + index.translate(_SUBSCRIPTS) + space + rest


def sentence(text: str) -> str:
    """Begin with a capital letter."""
    return text[:1].upper() + text[1:]
