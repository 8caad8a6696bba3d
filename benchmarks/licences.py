"""The licences of what MechStyle installs, from the packages' own metadata.

.venv/bin/python benchmarks/licences.py > docs/licences.md
"""

from __future__ import annotations

import importlib.metadata
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

EXTRAS = ("jupyter", "words", "step", "clip")  # what `dev` brings is not installed with MechStyle
COPYLEFT = re.compile(r"\b(?:A|L)?GPL|General Public License|MPL|Mozilla", re.IGNORECASE)
BUNDLED = {  # copyleft libraries inside wheels, by the beginning of their file names
    "libgmp": "GMP: LGPL-3.0-or-later or GPL-2.0-or-later",
    "libgomp": "libgomp: GPL-3.0 with the GCC runtime library exception",
    "libgfortran": "libgfortran: GPL-3.0 with the GCC runtime library exception",
    "libquadmath": "libquadmath: LGPL-2.1-or-later",
    "libzmq": "libzmq: MPL-2.0",
    "libTKernel": "Open CASCADE: LGPL-2.1 with its exception",
    "libstdc++": "libstdc++: GPL-3.0 with the GCC runtime library exception",
}
HEAD = """# Licences

MechStyle is [Apache-2.0](../LICENSE). What it needs is installed as its authors publish it. Made
by `.venv/bin/python benchmarks/licences.py > docs/licences.md` of the packages on Linux x86-64, without the extra `dev`; versions are those
of `constraints.txt`. No lawyer has read it.

**Copyleft in it.** Who passes on an image or an installer with these packages inside passes on their licences, too: the text, and for
MPL and LGPL parts where their source is.
"""
DATA = """
**Data in it.** `mechstyle/styling/english.tsv` is derived from WordNet 3.0 (Copyright 2006 by Princeton University) and SCOWL (Copyright
2000-2011 by Kevin Atkinson). Both allow any use with [their notices](../mechstyle/styling/english-notices.txt).
"""


def reached(requirements: list[str]) -> set[str]:
    """Packages that are installed and asked for by these requirements or by those of one another."""
    seen = set[tuple[str, frozenset[str]]]()
    ahead = [(need.name, frozenset(need.extras)) for need in map(Requirement, requirements)]
    while ahead:
        name, extras = ahead.pop()
        name = canonicalize_name(name)
        if (name, extras) in seen:
            continue
        try:
            needs = importlib.metadata.requires(name) or []
        except importlib.metadata.PackageNotFoundError:
            continue  # for another system or Python
        seen.add((name, extras))
        for need in map(Requirement, needs):
            if need.marker is None or any(need.marker.evaluate({"extra": extra}) for extra in (*extras, "")):
                ahead += [(need.name, frozenset(need.extras))]
    return {name for name, _ in seen}


def licence_of(name: str) -> str:
    """The licence a package declares: an SPDX expression, else its classifiers, else the first line of its licence field."""
    about = importlib.metadata.metadata(name)
    if expression := about.get("License-Expression"):
        return expression
    classified = [entry.rsplit(" :: ", 1)[-1] for entry in about.get_all("Classifier") or [] if entry.startswith("License :: ")]
    specific = [entry for entry in classified if entry != "OSI Approved"]
    told = next(iter((about.get("License") or "").strip().splitlines()), "")
    return " / ".join(specific) or told or "not declared; see its licence file"


def bundled_in(name: str) -> list[str]:
    """Copyleft libraries that lie in a wheel."""
    files = {file.name for file in importlib.metadata.files(name) or []}
    return [what for start, what in BUNDLED.items() if any(file.startswith((start + "-", start + ".")) for file in files)]


def remarks(names: set[str]) -> Iterator[str]:
    """A line on each package with copyleft in it."""
    for name in sorted(names):
        parts = ([licence_of(name)] if COPYLEFT.search(licence_of(name)) else []) + [f"bundles {what}" for what in bundled_in(name)]
        if parts:
            yield f"- **{name}**: {'; '.join(parts)}"


def main() -> None:
    """Print the page."""
    project = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text())["project"]
    core = reached(project["dependencies"])
    extra = {name: reached(project["optional-dependencies"][name]) - core for name in EXTRAS}
    if absent := [name for name, found in extra.items() if not found]:
        raise SystemExit(f"install what is listed first: pip install 'mechstyle[{','.join(absent)}]'")
    print(HEAD)
    print("\n".join(remarks(core.union(*extra.values()))))
    print(DATA, end="")
    for title, names in {"Always": core, **{f"With `mechstyle[{name}]`": found for name, found in extra.items()}}.items():
        print(f"\n## {title}\n\n| licence they declare | packages |\n|---|---|")
        declared = {licence_of(name).replace("|", "/") for name in names}
        for licence in sorted(declared):
            print(f"| {licence} | {', '.join(sorted(name for name in names if licence_of(name) == licence))} |")


if __name__ == "__main__":
    main()
