"""Whether a text of a Studio in German is German: a word that the table has on its English side alone is none."""

from __future__ import annotations

import re

from mechstyle.records.landings import STANDARDS
from mechstyle.records.material import LIBRARY
from mechstyle.records.regions import KINDS
from mechstyle_widgets.jupyter.language import GERMAN

NAMES = {
    "MechStyle", "Freestyle", "auto", "cpu", "cuda", "x", "y", "z", "standard", "prusa", "bambu", "orca", "mechstyle-runs/…", "\u200b",
    "\n".join(KINDS.values()), *LIBRARY, *(standard.title for standard in STANDARDS.values()),
}  # fmt: skip
"""Names of things, which are the same in every language."""
FIGURES = re.compile(r"[\d.×]+( mm)?|× \d+")
MADE = ("Material: ", "When to test: ", "Holding back: ", "Keep plain: ", "Drop test: ", "● ", "○ ")
"""How labels begin that are made of a heading and of what is chosen, or of a mark and a lane."""
ENGLISH = re.compile(r"(?i)\b(the|of|and|is|are|with|what|where|from|this|that|which|your|not|or|by|how|has|have|may|it|to|flat|plain)\b")
"""Words that no German sentence has."""
MARKUP = re.compile(r"<[^>]*>|&[a-z]+;")


def plain(label: str) -> bool:
    """Whether a label is a name, a figure, or made of others."""
    return label in NAMES or FIGURES.fullmatch(label) is not None or label.startswith(MADE)


def english_in(text: str) -> set[str]:
    """Words of a text that the table has on its English side alone; none of a name, a path or lines of code."""
    text = text.replace("\N{NO-BREAK SPACE}", " ")  # of an option in a page
    if text in NAMES or plain(text) or text.startswith("/") or "import mechstyle" in text:
        return set()
    text = re.sub(rf"branch-\d+|^({'|'.join(KINDS)})\b", "", text, flags=re.MULTILINE)  # a folder, and what regions begin with
    text = re.sub("&#x27;.*?&#x27;", "", text)  # what is quoted can be written so
    return {*ENGLISH.findall(text), *(words(text) & ONLY_ENGLISH)}


def words(text: str) -> set[str]:
    """Words of three letters and more."""
    return set(re.findall(r"[a-z]{3,}", text.lower()))


ONLY_ENGLISH = set().union(*map(words, GERMAN)) - set().union(*map(words, GERMAN.values()))
"""Words that the table has on its English side alone."""
