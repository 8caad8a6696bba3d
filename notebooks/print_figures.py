"""One figure per idea, for the wall or a handout: executes the notebooks and writes each figure that is tagged `print`, with its words.

python notebooks/print_figures.py OUT [NOTEBOOK…]
"""

from __future__ import annotations

import base64
import sys
import tempfile
from pathlib import Path
from typing import Any

import nbformat
from nbclient import NotebookClient

HERE = Path(__file__).parent
SHARP = "import matplotlib.pyplot as plt\nplt.rcParams['figure.dpi'] = 200  # twice that of a screen"
"""A first cell, for figures that are printed."""


def tagged(notebook: Any) -> list[Any]:
    """The cells whose figure is printed."""
    return [cell for cell in notebook.cells if "print" in cell.metadata.get("tags", [])]


def figures(notebook: Any) -> list[tuple[bytes, str]]:
    """PNG bytes and alternative text of the tagged figures of an executed notebook."""
    shown = [(cell, output.get("data", {})) for cell in tagged(notebook) for output in cell.outputs]
    return [(base64.b64decode(data["image/png"]), cell.metadata["alt"]) for cell, data in shown if "image/png" in data]


def main(out: Path, chosen: list[Path]) -> None:
    """Execute and write."""
    out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:  # one for all of them: what one lesson ran, the next only opens
        for path in chosen:
            notebook = nbformat.read(path, as_version=4)
            if not tagged(notebook):
                continue  # nothing of it is printed, and it would be waited for
            notebook.cells.insert(0, nbformat.v4.new_code_cell(SHARP))
            NotebookClient(notebook, timeout=None, resources={"metadata": {"path": folder}}).execute()
            for png, words in figures(notebook):
                (out / f"{path.stem}.png").write_bytes(png)
                (out / f"{path.stem}.txt").write_text(words + "\n", encoding="utf-8")
                print(out / f"{path.stem}.png")


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit("where to? python notebooks/print_figures.py OUT [NOTEBOOK…]")
    main(Path(sys.argv[1]), [Path(name) for name in sys.argv[2:]] or sorted(HERE.glob("0[1-9]*.ipynb")))
