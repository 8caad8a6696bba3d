"""Compare the simulation with textbook solutions, CalculiX, finer meshes and other arithmetic; exit code 1 if a figure fails.

python benchmarks/validate.py                          # every case of tests/validation/suite.py: hours on two cores
python benchmarks/validate.py --quick                  # without what takes minutes
python benchmarks/validate.py --case patch --case bar  # these alone
python benchmarks/validate.py --case bar --page        # and bring docs/validation.md up to date, the others as they were
python benchmarks/validate.py --case devices --json gpu.json          # on a machine with a GPU …
python benchmarks/validate.py --read gpu.json --page                  # … whose figures are taken over here, with nothing measured
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from mechstyle.errors import BadInput

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from validation import suite
from validation.cases import Case, named

DOCS = Path(__file__).parents[1] / "docs"
MARKS = {True: "[green]passed[/]", False: "[red]FAILED[/]", None: "[yellow]not run[/]"}


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the figures of the cases asked for, and write them where they are wanted."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--case", action="append", metavar="NAME", default=[], help="only this case; may be repeated")
    parser.add_argument("--quick", action="store_true", help="leave out what takes minutes")
    parser.add_argument("--page", nargs="?", const=DOCS, type=Path, metavar="FOLDER", help="write the page, into docs by default")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures")
    parser.add_argument(
        "--read", type=Path, nargs="+", metavar="FILE", default=[], help="figures measured elsewhere; only --case is measured"
    )
    asked, console = parser.parse_args(arguments), Console(highlight=False, soft_wrap=True)
    try:
        chosen = [named(name, suite.CASES) for name in asked.case]
    except BadInput as error:
        parser.error(str(error))
    if not (chosen or asked.read):
        chosen = [one for one in suite.CASES.values() if not (asked.quick and one.slow)]
    found = {name: one for file in asked.read for name, one in suite.read(file).items()}
    for case in chosen:
        found[case.name] = suite.Figures(suite.machine(), case.results())
        _tell(console, case, found[case.name])
    if asked.page:
        everything = suite.merged(suite.read(asked.page / "validation.json"), found)
        suite.write(asked.page / "validation.json", everything)
        suite.write_page(asked.page / "validation.md", everything)
    if asked.json:
        suite.write(asked.json, found)
    failed = [result.case for one in found.values() for result in one.ran if not result.passed]
    if failed:
        print(f"{len(failed)} of the figures lie outside their limits: {'; '.join(failed)}", file=sys.stderr)
    return int(bool(failed))


def _tell(console: Console, case: Case, found: suite.Figures) -> None:
    rows = Table("", "measured", "reference", "error", "limit", "", title=escape(case.title))
    for one in found.results:
        numbers = [f"{value:.4g}" for value in (one.measured, one.reference, one.error, one.limit)]
        rows.add_row(escape(one.case), *(numbers if one.passed is not None else [""] * 4), MARKS[one.passed])
    console.print(rows)
    console.print(*{f"  {escape(one.note)}" for one in found.results if one.passed is None})


if __name__ == "__main__":
    sys.exit(main())
