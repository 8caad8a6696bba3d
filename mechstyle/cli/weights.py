"""Commands about CLIP's weights: fetch, add, list, path. Nothing but fetch uses the network in MechStyle."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mechstyle._files import clip_folder
from mechstyle.cli.console import command, err, escape, out, print_json, table
from mechstyle.cli.options import Json
from mechstyle.styling.learned.weights import DEFAULT, KNOWN, OWN_FOLDER, Weights, add, fetch, located, need_clip_extra, stored

app = typer.Typer()
family = typer.Typer(no_args_is_help=True, help="CLIP weights, which styles from any prompt need (--guidance clip).")
app.add_typer(family, name="weights")


@family.command("fetch")
@command
def fetch_command(name: Annotated[str, typer.Argument(help=f"One of {', '.join(KNOWN)}.")] = DEFAULT, as_json: Json = False) -> None:
    """Download weights once, with their checksums; what is there and sound is left as it is."""
    need_clip_extra()
    if not as_json:
        err.print(f"[dim]fetching {escape(name)} to {escape(str(clip_folder()))}[/]")
    _tell(fetch(name, clip_folder()), as_json=as_json)


@family.command("add")
@command
def add_command(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A folder as transformers saves a CLIPModel and its CLIPTokenizer.")],
    name: Annotated[str, typer.Option(help="What to call them; by default as the folder is called.")] = "",
    as_json: Json = False,
) -> None:
    """Check weights of your own and copy them to where the fetched ones are, so that --clip NAME finds them."""
    need_clip_extra()
    _tell(add(folder, clip_folder(), name), as_json=as_json)


@family.command("list")
@command
def list_command(as_json: Json = False) -> None:
    """List the weights there are and which of them are on this machine."""
    here = {folder.name: folder for folder in stored(clip_folder())}
    sources = KNOWN | {name: "added" for name in here if name not in KNOWN}
    if as_json:
        print_json({"weights": [{"name": name, "source": source, "folder": here.get(name)} for name, source in sources.items()]})
        return
    rows = table("weights", "source", "on this machine")
    for name, source in sources.items():
        rows.add_row(escape(name), source, escape(str(here.get(name, f"no; get it with: mechstyle weights fetch {name}"))))
    out.print(rows)
    out.print(f"\nYour own: `mechstyle weights add DIR`, or --clip DIR in a run, or ${OWN_FOLDER} for all of them.")


@family.command("path")
@command
def path_command(
    name: Annotated[
        str, typer.Argument(help=f"Name of weights, or a folder; without it those a run would use: ${OWN_FOLDER}, else {DEFAULT}.")
    ] = "",
    as_json: Json = False,
) -> None:
    """Say where weights are, after verifying them."""
    need_clip_extra()
    found = located(name, clip_folder())
    if as_json:
        print_json({"folder": found.folder, "identity": found.identity})
    else:
        out.print(escape(str(found.folder)))


def _tell(found: Weights, *, as_json: bool) -> None:
    name = found.folder.name
    if as_json:
        print_json({"name": name, "folder": found.folder, "identity": found.identity})
    else:
        out.print(f"{escape(name)}: {escape(str(found.folder))}")
