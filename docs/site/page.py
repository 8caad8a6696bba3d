"""What a page of the site may load and run, and what it shows in place of what only a notebook or a mathematical font can."""

import base64
import hashlib
import json
import re

WIDGET = "application/vnd.jupyter.widget-view+json"
LIVE = "A live widget of the notebook, which needs a kernel: “make lab” opens it in JupyterLab."
"""What a page says where a notebook shows a widget."""
SCRIPT = re.compile(r"<script(?![^>]*\b(?:src=|type=[\"']?(?:application|text)/))[^>]*>(.*?)</script>", re.DOTALL)


def digest(script: str) -> str:
    """What a Content-Security-Policy calls a script by."""
    return f"'sha256-{base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()}'"


def policy(template: str) -> str:
    """Nothing from elsewhere, and no script but the site's own and those of a template; `file:` for a site opened without a server."""
    scripts = " ".join(["'self' file:", *map(digest, SCRIPT.findall(template))])
    return (
        f'<meta http-equiv="Content-Security-Policy" content="default-src \'none\'; script-src {scripts}; '
        "style-src 'self' file: 'unsafe-inline'; img-src 'self' file: data:; font-src 'self' file:; frame-src 'self' file:; "
        "connect-src 'self'; base-uri 'none'; form-action 'self' file:\">"
    )


def stopped(page: str) -> list[str]:
    """Scripts in a page that its policy stops, and a word if it has no policy."""
    if "Content-Security-Policy" not in page:
        return ["no Content-Security-Policy"]
    return [script.strip()[:60] for script in SCRIPT.findall(page) if digest(script) not in page]


def as_in_lab(text: str) -> str:
    """A notebook whose figures carry the words of their cell, and whose code is folded where it is in JupyterLab."""
    notebook = json.loads(text)
    for cell in notebook["cells"]:
        if cell["metadata"].get("jupyter", {}).get("source_hidden"):
            cell["metadata"]["tags"] = [*cell["metadata"].get("tags", []), "hide-input"]
        if "alt" in cell["metadata"]:
            cell["metadata"]["mystnb"] = {"image": {"alt": cell["metadata"]["alt"]}}
    return json.dumps(notebook)


def unbroken(text: str) -> str:
    """Words in which no line ends within a figure, or between a figure and its unit."""
    return re.sub(r"(?<=\d) (?=\d{3}\b|(?:MPa|mm|cm³|kB|MB|GB|ms|mJ|s|h|g|N)\b|%)", "\N{NO-BREAK SPACE}", text)


def with_roots(formula: str) -> str:
    """MathML whose roots are a letter and a line: without a mathematical font Chromium leaves the sign out, and says 2gh for its root."""
    return formula.replace("<msqrt>", '<mrow><mo stretchy="false">√</mo><mrow class="under-root">').replace("</msqrt>", "</mrow></mrow>")
