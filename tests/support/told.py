"""What a piece of a page says to who looks at it."""

import re

from mechstyle.records import sentences
from mechstyle_widgets.state.outcomes import LOOKS


def outcomes(html: str) -> set[str]:
    """Outcomes it says of what is on show; what is folded away, and rests under the mouse, tells of others, too."""
    seen = re.sub(r"<style>.*?</style>|<details>.*</details>", "", html, flags=re.DOTALL)
    seen = re.sub(r"<[^>]*>", " ", seen)
    return {one for one in (*LOOKS, sentences.NOT_TESTED) if re.search(rf"\b{one}\b", seen)}
