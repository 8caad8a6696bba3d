"""Read prompts, one a line of a file, print what each becomes, and count how many are right, offered, wrong or refused in vain.

After " => " a line may say which styles would be right, "brick|stone", and "!" if it should be refused. A refusal is of use if it is right,
or if one of the styles that it offers is.

python benchmarks/prompts.py PROMPTS.txt…
"""

from __future__ import annotations

import sys
from collections import Counter
from pathlib import Path
from typing import NamedTuple

from mechstyle.errors import BadInput
from mechstyle.styling.prompt import read, suggestions


class Outcome(NamedTuple):
    """What became of a prompt."""

    styles: set[str]  # its styles, "!" if it is refused
    said: str  # how it was read with its notes, or why it is refused
    offered: tuple[str, ...] = ()  # the styles that the refusal offers


def became(prompt: str) -> Outcome:
    """What a prompt becomes."""
    try:
        reading = read(prompt)
    except BadInput as refusal:
        return Outcome({"!"}, f"refused: {str(refusal).partition('; `mechstyle styles`')[0]}", suggestions(prompt))
    return Outcome({wish.style for wish in reading.wishes}, "; ".join([reading.words, *reading.notes]))


def judged(outcome: Outcome, right: set[str]) -> str:
    """How good an outcome is: "right", "offered", "wrong" or "useless"."""
    if outcome.styles & right:
        return "right"
    if outcome.styles != {"!"}:
        return "wrong"
    return "offered" if right.intersection(outcome.offered) else "useless"


def main() -> None:
    """Print every prompt with what it became, then the counts."""
    counts = Counter[str]()
    for line in [line for name in sys.argv[1:] for line in Path(name).read_text("utf-8").splitlines() if line and not line.startswith("#")]:
        prompt, _, right = line.partition(" => ")
        outcome = became(prompt)
        verdict = judged(outcome, set(right.split("|"))) if right else ""
        counts.update({"prompts": 1, "refused": outcome.styles == {"!"}, **({verdict: 1} if verdict else {})})
        print(f"{verdict:8}{prompt}\n        {outcome.said}")
    print(", ".join(f"{count} {what}" for what, count in counts.items()))


if __name__ == "__main__":
    main()
