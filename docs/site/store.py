"""Store a notebook with what it shows, small enough to be looked at where the repository is browsed: `python docs/site/store.py NOTEBOOK…`.

Pictures are reduced to a palette; what a cell says to a log and the numbers of executions are left out, so that two executions differ by
what differs.
"""

import base64
import io
import sys
import tempfile
import time
from pathlib import Path

import nbformat
from nbclient import NotebookClient
from PIL import Image

COLOURS = 256
WIDGET = "application/vnd.jupyter.widget-view+json"


def small(png: str) -> str:
    """A picture in base64, with fewer colours."""
    whole, reduced = Image.open(io.BytesIO(base64.b64decode(png))).convert("RGB"), io.BytesIO()
    # The palette covers all colours and is refined: the median cut has none left for what is small, such as the hatch above a limit.
    palette = whole.quantize(COLOURS, Image.Quantize.MAXCOVERAGE, kmeans=1, dither=Image.Dither.NONE)
    palette.save(reduced, "PNG", optimize=True)
    return base64.b64encode(reduced.getvalue()).decode()


def stored(executed: nbformat.NotebookNode, notebook: nbformat.NotebookNode) -> nbformat.NotebookNode:
    """A notebook with what another, executed, shows; both have the same cells."""
    for cell, done in zip(notebook.cells, executed.cells, strict=True):
        if cell.cell_type == "code":
            cell.outputs = [output for output in done.outputs if output.get("name") != "stderr"]
            for output in cell.outputs:
                output.pop("execution_count", None)
                output.get("data", {}).pop(WIDGET, None)  # without a kernel there is nothing behind it
                if output.output_type == "execute_result":
                    output["output_type"] = "display_data"
                if "image/png" in output.get("data", {}):
                    output.data["image/png"] = small(output.data["image/png"])
    return notebook


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:  # one for all of them, as in a class: each opens what an earlier one ran
        for place in map(Path, sys.argv[1:]):
            begun = time.perf_counter()
            plain = nbformat.read(place, as_version=4)
            client = NotebookClient(nbformat.read(place, as_version=4), kernel_name="python3", resources={"metadata": {"path": folder}})
            executed_now = client.execute()
            nbformat.write(stored(executed_now, plain), place)
            print(f"{place}: {place.stat().st_size / 1000:.0f} kB, {time.perf_counter() - begun:.0f} s", flush=True)
