"""How Sphinx makes a site of the repository: `make docs`, in CONTRIBUTING.md.

The repository itself is the source, so that a link between its pages leads to the same place here as where it is browsed. Nothing is loaded
from a network: notebooks show pictures instead of live widgets, and formulas are MathML.
"""

import os
import sys
from pathlib import Path
from typing import Any

import furo
from docutils import nodes
from docutils.utils.math.latex2mathml import tex2mathml

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "docs" / "site"))
sys.path.insert(0, str(ROOT))

import generated  # noqa: E402 — of the folder that has just been named
import page  # noqa: E402 — likewise

import mechstyle  # noqa: E402

EXECUTE = os.environ.get("MECHSTYLE_DOCS_EXECUTE", "cache")
"""`cache` runs each notebook once, and again when its code changes; `off` shows what is stored in them."""
CACHE = ROOT / "build" / "docs-cache"
POLICY = page.policy((Path(furo.__file__).parent / "theme" / "furo" / "base.html").read_text(encoding="utf-8"))
"""The theme makes a page dark by a script in the page, before it is seen."""

project = "MechStyle"
release = version = mechstyle.__version__
copyright = "MechStyle contributors, Apache-2.0"  # noqa: A001 — Sphinx calls it so
root_doc = "docs/index"
include_patterns = ["docs/*.md", "notebooks/**", "CHANGELOG.md", "CONTRIBUTING.md", "CODE_OF_CONDUCT.md", "SECURITY.md"]
exclude_patterns = ["build", ".*", "**/.*", "**/node_modules", "notebooks/slides"]
extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.viewcode"]
suppress_warnings = ["mystnb.unknown_mime_type"]  # figures to turn, beside which a picture is kept
smartquotes = False  # two hyphens begin an option

html_theme = "furo"
html_title = "MechStyle"
html_static_path = ["site/static"]
html_css_files = ["site.css"]
html_js_files = ["site.js"]
html_extra_path = [str(CACHE / "extra")]
html_copy_source = False
html_show_sphinx = False
html_additional_pages = {"index": "to_the_start.html"}
templates_path = ["site/templates"]
pygments_style = "a11y-high-contrast-light"
pygments_dark_style = "a11y-high-contrast-dark"
html_math_renderer = "mathml"

myst_enable_extensions = ["colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3
nb_execution_mode = EXECUTE
nb_execution_cache_path = str(CACHE / "notebooks")
nb_execution_in_temp = True
nb_execution_timeout = 1800
nb_execution_raise_on_error = True
nb_execution_show_tb = True
nb_ipywidgets_js: dict[str, Any] = {}  # or require.js would be loaded from a network
nb_merge_streams = True

autodoc_member_order = "bysource"
autodoc_typehints = "description"
autodoc_typehints_description_target = "documented"
autodoc_preserve_defaults = True
default_role = "code"
napoleon_google_docstring = True
napoleon_numpy_docstring = False
napoleon_use_ivar = True


def filled(_app: Any, name: str, source: list[str]) -> None:
    """Put what is generated where a page asks for it, and what a notebook says of its cells where myst-nb looks for it."""
    if (ROOT / f"{name}.ipynb").is_file():
        source[0] = page.as_in_lab(source[0])
        return
    for marker, made in generated.PAGES.items():
        if f"<!-- {marker} -->" in source[0]:
            source[0] = source[0].replace(f"<!-- {marker} -->", made(CACHE, EXECUTE))


def formula(self: Any, node: nodes.math) -> None:
    """A formula within a line."""
    self.body.append(page.with_roots(tex2mathml(node.astext())))
    raise nodes.SkipNode


def formulas(self: Any, node: nodes.math_block) -> None:
    """A formula on a line of its own."""
    self.body.append(f'<div class="math">{page.with_roots(tex2mathml(node.astext(), as_block=True))}</div>')
    raise nodes.SkipNode


def without_widgets(app: Any, document: nodes.document) -> None:
    """A sentence for each live widget, and none of their state, which is megabytes that nothing on a page reads."""
    getattr(app.env, "nb_metadata", {}).get(app.env.docname, {}).pop("js_files", None)
    for shown in document.findall(nodes.container):
        if shown.get("mime_type") == page.WIDGET:
            shown.children = [nodes.paragraph("", "", nodes.emphasis("", page.LIVE))]


AS_TYPED = (nodes.literal, nodes.math, nodes.FixedTextElement, nodes.raw)
"""What holds text that stays as it is."""


def whole_figures(_app: Any, document: nodes.document) -> None:
    """No figure is broken at the end of a line; what one types stays as it is."""
    for text in list(document.findall(nodes.Text)):
        if (
            not isinstance(text.parent, nodes.literal | nodes.math | nodes.FixedTextElement | nodes.raw)
            and (whole := page.unbroken(text)) != text
        ):
            text.parent.replace(text, nodes.Text(whole))


def sealed(_app: Any, _name: str, _template: str, context: dict[str, Any], _document: nodes.document | None) -> None:
    """A page that loads nothing from elsewhere."""
    context["metatags"] = POLICY + context.get("metatags", "")


def setup(app: Any) -> None:
    """Tell Sphinx of the above."""
    app.add_html_math_renderer("mathml", (formula, None), (formulas, None))
    app.connect("source-read", filled)
    app.connect("doctree-read", without_widgets)
    app.connect("doctree-read", whole_figures)
    app.connect("html-page-context", sealed)
    (CACHE / "extra").mkdir(parents=True, exist_ok=True)
    if EXECUTE != "off":
        generated.report(CACHE)
