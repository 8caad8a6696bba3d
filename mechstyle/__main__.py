"""`mechstyle` and `python -m mechstyle`."""

import typer

from mechstyle.cli import comparing, listing, looking, making, protecting, reporting, testing, validating, weights

app = typer.Typer(
    name="mechstyle",
    help="Style a 3D-printable model from a prompt while a drop test watches its strength. Lengths in mm, stresses in MPa.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
)
for family in (making, testing, comparing, validating, looking, protecting, reporting, listing, weights):
    app.add_typer(family.app)


def main() -> None:
    """Run the command line."""
    app()


if __name__ == "__main__":
    main()
