"""Commands that list what there is: materials, styles, gallery."""

from __future__ import annotations

import typer

from mechstyle.cli.console import command, escape, out, print_json, table
from mechstyle.cli.options import Json

app = typer.Typer()


@app.command("materials")
@command
def materials_command(as_json: Json = False) -> None:
    """List the material library with its sources, and how far the figures of brands lie apart."""
    from mechstyle.records.material import LIBRARY, SPREAD  # noqa: PLC0415 — loaded when wanted

    if as_json:
        print_json({"materials": list(LIBRARY.values()), "spread": SPREAD})
        return
    rows = table("material", "E [MPa]", "ν", "ρ [g/mm³]", "yield [MPa]", "across layers", "source")
    for m in LIBRARY.values():
        layers = "not known" if m.layer_ratio is None else f"x {m.layer_ratio:g}"
        figures = (f"{m.youngs_modulus:g}", f"{m.poisson_ratio:g}", f"{m.density:g}", f"{m.yield_strength:g}", layers)
        rows.add_row(m.name, *figures, escape(m.source))
    out.print(rows)
    out.print("\nThese are generic: a verdict is no better than they are. What is sold under the name lies apart:")
    for name, spread in SPREAD.items():
        out.print(f"  {name}: {spread}")
    out.print("Strength across printed layers is judged with --build-direction; without it a material is alike in all directions.")
    out.print(
        "\nYour own: a .toml or .json file with name, youngs_modulus, poisson_ratio, density, yield_strength, as its data sheet states."
    )


@app.command("styles")
@command
def styles_command(as_json: Json = False) -> None:
    """List the offline styles and the words that call them."""
    from mechstyle.styling.library import library  # noqa: PLC0415 — loaded when wanted
    from mechstyle.styling.vocabulary import called  # noqa: PLC0415 — as above

    known = library().values()
    if as_json:
        found = [{"name": s.name, "words": called(s.name), "description": s.description, "feature_mm": s.feature_mm} for s in known]
        print_json({"styles": found})
        return
    rows = table("style", "also called", "what it is")
    for style in known:
        rows.add_row(style.name, escape(", ".join(word.replace("_", " ") for word in called(style.name))), escape(style.description))
    out.print(rows)


@app.command("gallery")
@command
def gallery_command(as_json: Json = False) -> None:
    """List the built-in parametric models, what one learns from each, what to protect of it and what it carries."""
    from mechstyle.gallery import entry, names  # noqa: PLC0415 — loaded when wanted

    known = {name: entry(name) for name in names()}
    if as_json:
        models = [
            {"name": name, "description": one.about, "teaches": one.teaches, "protect": one.protect, "use": one.use}
            for name, one in known.items()
        ]
        print_json({"models": models})
        return
    rows = table("model", "what it is", "what it teaches", "--protect", "--load")
    for name, one in known.items():
        use = one.use.name if one.use else "–"
        rows.add_row(f"gallery:{name}", escape(one.about), escape(one.teaches), escape("; ".join(one.protect)), use)
    out.print(rows)
    out.print("\nThe load of its use: --load gallery:NAME. Regions are suggestions, one --protect for each.")
