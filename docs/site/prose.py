"""Refuse pages that are hard to read or that name what does not exist: `python docs/site/prose.py`.

Every Markdown page and the text of every notebook is read. Code blocks are left out, except for the commands in them.
"""

import json
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent.parent
SENTENCE, PARAGRAPH, ALL, GENERATED = 35, 90, 14_000, 8_000
"""Most words of a sentence, of a paragraph, of all pages written in docs/, and of all that a program has written, without docstrings."""
PAGES, SIDEBAR = 23, 26
"""Most written pages in docs/, and most links in the sidebar of the site."""
LINES = {"README.md": 90, "CHANGELOG.md": 20}
WORDS = {"docs/how-mechstyle-judges.md": 1000, "docs/published-study.md": 700}
"""Most words of a page, marks of its tables included."""
STOP = re.compile(
    r"\b([Tt]old|[Tt]ells?|[Bb]orne|[Bb]ears?|[Aa]s it c[ao]me|[Aa]s it comes|[Nn]o longer|[Oo]n show|[Oo]f no account|[Aa]ll the same"
    r"|[Hh]eld against|[Bb]eside|[Uu]nless said|[Ww]hat is delivered|[Pp]hysics \d+|[Uu]sed to be|[Uu]p to now|[Uu]ntil now|TODO)\b"
)
"""Words that say less than the noun of the field, and words of a history that no reader has."""
WRITTEN_BY_A_PROGRAM = re.compile(r"\b(?:[Ww]ritten|[Mm]ade)\s+by\s+`(?:python |\.venv)|by `python -m benchmarks\.study page |<!-- every ")
FENCE = re.compile(r"^(```+|:::+).*?^\1\s*$", re.DOTALL | re.MULTILINE)
SPAN = re.compile(r"`[^`\n]*`")
LINK = re.compile(r"\]\(([^()\s]+)\)")
COMMAND = re.compile(r"^(?:\. \S+ && |cd \S+ && )?((?:mechstyle|make|python|pip)\b.*?)(?: +#.*)?$")
FOREIGN = frozenset(
    ("--nworkers", "--nthreads", "--host", "--no-dashboard", "--resources", "--lifetime", "--lifetime-stagger", "--template")
)
"""Options of other programs."""


def pages() -> list[Path]:
    """Every page that somebody reads, without the pages of decisions."""
    return sorted(path for pattern in ("*.md", "docs/*.md", "notebooks/*.ipynb", "notebooks/solutions/*.md") for path in ROOT.glob(pattern))


def markdown(page: Path) -> str:
    """The text of a page or a notebook."""
    text = page.read_text(encoding="utf-8")
    if page.suffix != ".ipynb":
        return text
    return "\n\n".join("".join(cell["source"]) for cell in json.loads(text)["cells"] if cell["cell_type"] == "markdown")


def blocks(text: str) -> Iterator[tuple[int, str]]:
    """Paragraphs, list items, headings and cells of tables, each with its line."""
    blank = FENCE.sub(lambda found: "\n" * found[0].count("\n"), text)
    blank = re.sub(r"<!--.*?-->|^\$\$.*?\$\$", lambda found: "\n" * found[0].count("\n"), blank, flags=re.DOTALL | re.MULTILINE)
    first, held = 0, ""
    for number, line in enumerate([*blank.splitlines(), ""], 1):
        begins = not line.strip() or re.match(r"\s*([-*+]|\d+\.)\s|#|\||>|!\[|    |\(\w+\)=", line)
        if begins and held:
            yield first, held
            held = ""
        if line.lstrip().startswith("|"):
            yield from ((number, cell) for cell in line.strip().strip("|").split("|") if re.search(r"\w", cell))
        elif line.strip() and not line.startswith("    "):
            first = first if held else number
            held += " " + line.strip()


def plain(block: str) -> str:
    """A block without the targets of its links, and one word for each piece of code."""
    return re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", re.sub(r"[*_]{2}", "", SPAN.sub("Code", block)))


def words(block: str) -> int:
    """How many words a block has."""
    return sum(bool(re.search(r"\w", word)) for word in plain(block).split())


def sentences(block: str) -> list[str]:
    """The sentences of a block."""
    return re.split(r"(?<=[.!?])[)\"”»*]*\s+(?=[\"“«(*]*[A-Z0-9ÄÖÜσ`\[])", plain(block).strip(" -*+#>"))


def unreadable(text: str) -> Iterator[str]:
    """Stop words, and paragraphs and sentences that are too long."""
    for line, block in blocks(text):
        if found := STOP.search(plain(block)):
            yield f"{line}: “{found[0]}”"
        if (count := words(block)) > PARAGRAPH:
            yield f"{line}: a paragraph of {count} words, {PARAGRAPH} at most: {plain(block).strip()[:30]}…"
        yield from (
            f"{line}: a sentence of {count} words, {SENTENCE} at most: {sentence[:30]}…"
            for sentence in sentences(block) if (count := words(sentence)) > SENTENCE
        )  # fmt: skip


def written(text: str) -> int:
    """Words of a page that somebody has written; none if a program has."""
    return 0 if WRITTEN_BY_A_PROGRAM.search(text) else sum(words(block) for _, block in blocks(text))


def anchors(page: Path) -> set[str]:
    """Places within a page, named as GitHub names them."""
    titles = re.findall(r"^#+ (.+)$", markdown(page), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}


def broken(page: Path) -> list[str]:
    """Links of a page to files and places that do not exist."""
    found = []
    for link in LINK.findall(SPAN.sub("", FENCE.sub("", markdown(page)))):
        path, _, place = link.partition("#")
        target = (page.parent / path).resolve() if path else page
        if re.match(r"[a-z]+:", link):
            continue
        if not target.exists() or (place and place not in anchors(target)):
            found.append(link)
    return found


def options(command: Any) -> set[str]:
    """Every option of a command and of the commands below it."""
    below = getattr(command, "commands", {}).values()
    own = {option for one in command.params for option in (*one.opts, *one.secondary_opts) if option.startswith("-")}
    return {"--help"}.union(own, *map(options, below))


def missing(text: str, command: Any, public: set[str]) -> Iterator[str]:
    """Commands, options, targets, scripts and public names that a page shows and that do not exist.

    Args:
        text: The Markdown of a page.
        command: The command line, as Click has it.
        public: Names that `ms.` may precede.
    """
    lines = [line.strip() for found in FENCE.finditer(text) for line in found[0].splitlines()]
    spans = [found[0].strip("`").strip() for found in SPAN.finditer(FENCE.sub("", text))]
    targets = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE))
    for shown in (found[1] for line in (*lines, *spans) if (found := COMMAND.match(line))):
        program, _, rest = shown.partition(" ")
        if program == "mechstyle":
            yield from _wrong(command, shown)
        elif program == "make":
            named = [word for word in rest.split() if re.fullmatch(r"[a-z-]+", word)]
            yield from (f"make has no target {word!r}" for word in named if word not in targets)
        elif script := re.match(r"(?:docs|benchmarks|notebooks)/\S+\.py", rest):
            yield from () if (ROOT / script[0]).is_file() else (f"there is no {script[0]}",)
    for option in {found for span in spans for found in re.findall(r"^--[a-z][\w-]*", span)} - options(command) - FOREIGN:
        yield f"no command has the option {option}"
    for name in {found for piece in (*lines, *spans) for found in re.findall(r"\bms\.(\w+)", piece)} - public:
        yield f"there is no ms.{name}"


def _wrong(command: Any, shown: str) -> Iterator[str]:
    """What a shown command has that the command line does not know."""
    rest = shown.split()[1:]
    while getattr(command, "commands", None) and rest and re.fullmatch(r"[a-z]+", rest[0]):
        if rest[0] not in command.commands:
            yield f"there is no command {shown!r}"
            return
        command = command.commands[rest.pop(0)]
    given = re.findall(r"(?<!\S)--?[a-z][\w-]*", " ".join(rest))
    yield from (f"{shown!r}: no option {option}" for option in given if option not in options(command))


def found() -> Iterator[str]:
    """Everything that is wrong with the pages, in the order of their names."""
    import typer  # noqa: PLC0415 — the command line takes a second to load, and most of this file does without

    import mechstyle  # noqa: PLC0415
    from mechstyle.cli.app import app  # noqa: PLC0415

    command, total = typer.main.get_command(app), 0
    for page in (*pages(), *sorted(ROOT.glob("docs/decisions/*.md"))):
        text, name = markdown(page), str(page.relative_to(ROOT))
        total += written(text) if page.parent == ROOT / "docs" else 0
        wrong = [*unreadable(text), *(f"a link to {link}" for link in broken(page)), *missing(text, command, set(dir(mechstyle)))]
        if (most := LINES.get(name)) and (lines := text.count("\n")) > most:
            wrong.append(f"{lines} lines, {most} at most")
        yield from (f"{name}:{line}" if line[0].isdigit() else f"{name}: {line}" for line in wrong)
    yield from large(total)


def large(total: int) -> Iterator[str]:
    """What is more than may be: pages, words of all and of some, links in the sidebar."""
    import generated  # noqa: PLC0415 — as above

    docs = {path: path.read_text(encoding="utf-8") for path in sorted(ROOT.glob("docs/*.md"))}
    made = [*(text for text in docs.values() if not written(text)), *(make(Path(), "off") for make in generated.PAGES.values())]
    listed = re.findall(r"```\{toctree\}\n(.*?)```", docs[ROOT / "docs" / "index.md"], re.DOTALL)
    counts = (
        (total, ALL, "words are written in docs/"),
        (sum(words(block) for text in made for _, block in blocks(text)), GENERATED, "words are generated"),
        (sum(bool(written(text)) for text in docs.values()), PAGES, "pages are written in docs/"),
        (sum(bool(re.match(r"[^:\s]", line)) for block in listed for line in block.splitlines()), SIDEBAR, "links are in the sidebar"),
        *((len((ROOT / name).read_text(encoding="utf-8").split()), most, f"words are in {name}") for name, most in WORDS.items()),
    )
    yield from (f"{count} {what}, {most} at most" for count, most, what in counts if count > most)


if __name__ == "__main__":
    sys.path[:0] = [str(ROOT), str(Path(__file__).parent)]
    if "--count" in sys.argv:
        for one in pages():
            print(f"{written(markdown(one)):6} {one.relative_to(ROOT)}")
    problems = list(found())
    print(*problems, sep="\n") if problems else print("every page is short, plain, and names what exists")
    sys.exit(bool(problems))
