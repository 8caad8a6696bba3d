"""The scripts and styles of the replay as one text each, for a page or a notebook that may load nothing else."""

from __future__ import annotations

import re
from collections.abc import Iterable
from importlib.resources import files

MODULES = ("replay_data", "shaders", "camera", "scene", "player")
"""ES modules of the replay, each importing only earlier ones."""

IN_A_REPORT = (*MODULES, "impact")
"""Those of a report."""

_IMPORT = re.compile(r'^import \{[^}]*\} from "\./(\w+)\.js";\n', re.MULTILINE)
_EXPORT = re.compile(r"^export (?=(?:async )?(?:function|class|const) )", re.MULTILINE)


def static(name: str) -> str:
    """The text of a file in `static`."""
    return files("mechstyle.runs.report").joinpath("static", name).read_text(encoding="utf-8")


def bundle(last: str, modules: Iterable[str] = MODULES) -> str:
    """The modules, then `last`, the text of one that imports them, as one script.

    Our modules share no top-level name, so joining them is dropping the import lines and the word `export`.
    """
    parts = [_EXPORT.sub("", _IMPORT.sub("", static(f"{name}.js"))) for name in modules]
    return "\n".join([*parts, _IMPORT.sub("", last)])
