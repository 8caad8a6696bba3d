"""`mechstyle` and `python -m mechstyle`."""

import typer

from mechstyle.cli import demo, inspect_run, lists, protect, report, run, simulate, validate, weights

app = typer.Typer(
    name="mechstyle",
    help="Style a 3D-printable model from a prompt while a drop test watches its strength. Lengths in mm, stresses in MPa.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
)
for family in (run, simulate, demo, validate, inspect_run, protect, report, lists, weights):
    app.add_typer(family.app)


def main() -> None:
    """Run the command line."""
    app()


if __name__ == "__main__":
    main()
