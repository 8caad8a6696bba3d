"""Public names that are loaded when they are asked for. They stand once, in the stub beside a module, where type checkers read them too."""

from __future__ import annotations

import ast
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any


def attached(name: str, file: str) -> tuple[Callable[[str], Any], Callable[[], list[str]], list[str]]:
    """What a module takes as its `__getattr__`, `__dir__` and `__all__`.

    Args:
        name: Its name.
        file: Its file; the imports of the stub `.pyi` beside it are its public names.
    """
    stub = ast.parse(Path(file).with_suffix(".pyi").read_text("utf-8"))
    homes = {alias.name: node.module or "" for node in stub.body if isinstance(node, ast.ImportFrom) for alias in node.names}

    def load(wanted: str) -> Any:
        if wanted not in homes:
            raise AttributeError(f"module {name!r} has no attribute {wanted!r}")
        home = homes[wanted]
        value = import_module(f"{name}.{wanted}") if home == name else getattr(import_module(home), wanted)
        vars(import_module(name))[wanted] = value
        return value

    return load, lambda: sorted({*homes, *(["__version__"] if name == "mechstyle" else [])}), sorted(homes)
