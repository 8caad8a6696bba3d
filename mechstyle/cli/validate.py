"""The command that holds the simulation against what is known: validate."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mechstyle.cli.console import command, escape, fail, out, print_json, table
from mechstyle.cli.options import Json

app = typer.Typer()

MARKS = {True: "[green]passed[/]", False: "[red]FAILED[/]", None: "[yellow]not run[/]"}


@app.command("validate")
@command
def validate_command(
    names: Annotated[list[str] | None, typer.Option("--case", metavar="NAME", help="Only this case; may be repeated.")] = None,
    quick: Annotated[bool, typer.Option("--quick", help="Leave out what takes minutes.")] = False,
    folder: Annotated[Path | None, typer.Option("--out", help="Folder for a table and a plot.")] = None,
    page: Annotated[Path | None, typer.Option(help="Markdown page to write.")] = None,
    as_json: Json = False,
) -> None:
    """Hold the simulation against textbook solutions, CalculiX, finer meshes and other arithmetic; non-zero exit if it fails."""
    from mechstyle.simulation.validation import suite  # noqa: PLC0415 - physics is loaded when something is run
    from mechstyle.simulation.validation.cases import named  # noqa: PLC0415

    chosen = [named(name, suite.CASES) for name in names] if names else [case for case in suite.CASES.values() if not (quick and case.slow)]
    found = []
    for case, results in suite.run(chosen):
        found.append((case, results))
        if not as_json:
            rows = table("", "measured", "reference", "error", "limit", "", title=escape(case.title))
            for one in results:
                numbers = [f"{value:.4g}" for value in (one.measured, one.reference, one.error, one.limit)]
                rows.add_row(escape(one.case), *(numbers if one.passed is not None else [""] * 4), MARKS[one.passed])
            out.print(rows)
            out.print(*{f"  {escape(one.note)}" for one in results if one.passed is None})
    if folder is not None:
        suite.write_page(folder / "validation.md", found)
        suite.draw(folder / "validation.png", found)
    if page is not None:
        suite.write_page(page, found)
    if as_json:
        print_json({"cases": [one for _, results in found for one in results]})
    failed = [one.case for _, results in found for one in results if one.passed is False]
    if failed:
        fail(f"{len(failed)} of the figures lie outside their limits: {'; '.join(failed)}", 1, as_json=False)
