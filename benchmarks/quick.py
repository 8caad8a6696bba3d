"""Whether a quick run comes to the outcome of the default: the table of docs/speed.md, from the files of `profile_stages.py`.

A part's files are called NAME-quick.json and NAME-default.json:

    python benchmarks/profile_stages.py gallery:NAME --quick --json FOLDER/NAME-quick.json
    python benchmarks/profile_stages.py gallery:NAME --json FOLDER/NAME-default.json
    python benchmarks/quick.py FOLDER
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

COLUMNS = ("part", "quick", "default", "same", "quick: seconds", "on the processor", "tests", "kept: quick", "default")


def row(name: str, quick: dict[str, Any], default: dict[str, Any] | None) -> str:
    """A line of the table; a dash stands for a default run that was not made."""
    usual = "–" if default is None else outcome(default)
    same = "–" if default is None else "yes" if quick["outcome"] == default["outcome"] else "**no**"
    cells = (
        name.replace("_", " "), outcome(quick), usual, same, f"{quick['clock']:.0f}", f"{quick['cpu']:.0f}", str(quick["tests"]),
        f"{quick['kept']:.2f}", "–" if default is None else f"{default['kept']:.2f}",
    )  # fmt: skip
    return "| " + " | ".join(cells) + " |"


def outcome(found: dict[str, Any]) -> str:
    """An outcome, with its doubt if it has one."""
    return found["outcome"] if found["sure"] else f"{found['outcome']} (not sure)"


def table(folder: Path) -> str:
    """Every part of a folder, and how many are the same."""
    lines, same, compared = ["| " + " | ".join(COLUMNS) + " |", "|" + "---|" * len(COLUMNS)], 0, 0
    for file in sorted(folder.glob("*-quick.json")):
        name = file.name.removesuffix("-quick.json")
        usual = folder / f"{name}-default.json"
        quick, default = json.loads(file.read_text()), json.loads(usual.read_text()) if usual.is_file() else None
        lines.append(row(name, quick, default))
        compared += default is not None
        same += default is not None and quick["outcome"] == default["outcome"]
    return "\n".join([*lines, "", f"{same} of {compared} the same."])


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    print(table(parser.parse_args().folder))


if __name__ == "__main__":
    main()
