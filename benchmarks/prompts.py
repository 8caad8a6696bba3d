"""Read prompts, one a line of a file, and print for a person to judge what each becomes; count what is refused and what is wrong.

After " => " a line may say which styles would be right, "brick|stone", and "!" if it should be refused.

python benchmarks/prompts.py PROMPTS.txt…
"""

from __future__ import annotations

import sys
from collections import Counter
from pathlib import Path

from mechstyle.errors import BadInput
from mechstyle.styling.prompt import read


def became(prompt: str) -> tuple[set[str], str]:
    """The styles of a prompt, "!" if it is refused, and how it was read with its notes, or why it is refused."""
    try:
        reading = read(prompt)
    except BadInput as refusal:
        return {"!"}, f"refused: {str(refusal).partition('; `mechstyle styles`')[0]}"
    return {wish.style for wish in reading.wishes}, "; ".join([reading.words, *reading.notes])


def main() -> None:
    """Print every prompt with what it became, then the counts."""
    counts = Counter[str]()
    for line in [line for name in sys.argv[1:] for line in Path(name).read_text("utf-8").splitlines() if line and not line.startswith("#")]:
        prompt, _, right = line.partition(" => ")
        styles, said = became(prompt)
        wrong = bool(right) and styles.isdisjoint(right.split("|"))
        counts.update({"prompts": 1, "refused": styles == {"!"}, "not as they should be": wrong})
        print(f"{'WRONG ' * wrong}{prompt}\n    {said}")
    print(", ".join(f"{count} {what}" for what, count in counts.items()))


if __name__ == "__main__":
    main()
