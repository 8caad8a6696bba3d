"""Refuse a built site that loads anything from a network, or whose pages let it: `python docs/site/check.py build/site`."""

import re
import sys
from pathlib import Path

from page import stopped

LOADS = re.compile(
    r"""<(?:script|img|iframe|source|video|audio|embed)\b[^>]*?\bsrc=["']?(?:https?:)?//"""
    r"""|<link\b(?=[^>]*\brel=["']?(?:stylesheet|preload|prefetch|preconnect|icon|shortcut))[^>]*?\bhref=["']?(?:https?:)?//"""
    r"""|@import\s+(?:url\()?["']?(?:https?:)?//|url\(["']?(?:https?:)?//""",
    re.IGNORECASE,
)
"""What makes a browser fetch something from elsewhere; a link that somebody may follow does not."""


def loaded_from_elsewhere(site: Path) -> list[str]:
    """Every file of a site that makes a browser fetch from a network, with what it does it by."""
    pages = [path for path in sorted(site.rglob("*")) if path.suffix in (".html", ".css")]
    found = ((path, LOADS.search(path.read_text(encoding="utf-8"))) for path in pages)
    return [f"{path.relative_to(site)}: {match[0][-120:]}" for path, match in found if match]


def unsealed(site: Path) -> list[str]:
    """Every page of a site that has no policy, or scripts that its own policy stops."""
    pages = ((path, stopped(path.read_text(encoding="utf-8"))) for path in sorted(site.rglob("*.html")))
    return [f"{path.relative_to(site)}: {line}" for path, found in pages for line in found]


if __name__ == "__main__":
    if not Path(sys.argv[1], "index.html").is_file():
        sys.exit(f"{sys.argv[1]} holds no site: build it with make docs")
    wrong = [*loaded_from_elsewhere(Path(sys.argv[1])), *unsealed(Path(sys.argv[1]))]
    print(*wrong, sep="\n") if wrong else print(f"{sys.argv[1]}/index.html loads nothing from a network, and no page would let it")
    sys.exit(bool(wrong))
