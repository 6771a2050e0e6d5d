"""What a wheel brings beside the package: the man page and the completions of shells.

Both are made of the command's own parser, whose modules import nothing that has to be installed.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class ExtraFiles(BuildHookInterface):  # type: ignore[type-arg]
    """Adds them to a wheel, where shells and man look for them."""

    PLUGIN_NAME = "custom"

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:  # noqa: ARG002
        """Write the files, and name the places they go to."""
        sys.path.insert(0, self.root)
        from scripts.extra_files import PLACES, made

        self.folder = tempfile.TemporaryDirectory()
        for name, text in made().items():
            path = Path(self.folder.name) / name
            path.write_text(text, encoding="utf-8")
            build_data["shared_data"][str(path)] = PLACES[name]

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:  # noqa: ARG002
        """Clear away what the wheel now holds."""
        self.folder.cleanup()
