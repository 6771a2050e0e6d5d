"""Matrices as ``cv2.FileStorage`` reads them, YAML."""

from __future__ import annotations

from bayescal.arrays import Array

HEADER = ("%YAML:1.0", "---")


def matrix_lines(name: str, array: Array) -> list[str]:
    """Lines of a named matrix, ``(rows, columns)``."""
    rows, columns = array.shape
    numbers = ", ".join(repr(v) for v in array.ravel().tolist())
    lines = [f"{name}: !!opencv-matrix", f"   rows: {rows}", f"   cols: {columns}"]
    return [*lines, "   dt: d", f"   data: [ {numbers} ]"]


def list_lines(name: str, words: tuple[str, ...]) -> list[str]:
    """Lines of a named list of words."""
    return [f"{name}:", *(f"   - {word}" for word in words)]
