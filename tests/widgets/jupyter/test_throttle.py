"""Ten updates a second at most, the last one always; and a cell that runs again takes away what it made before."""

from __future__ import annotations

import asyncio
from types import SimpleNamespace

import IPython
import ipywidgets
from comm import get_comm_manager

from mechstyle_widgets.jupyter.cell_output import OncePerCell
from mechstyle_widgets.jupyter.looks import close_family
from mechstyle_widgets.jupyter.throttle import SHORTEST_WAIT, Throttled


def test_in_a_loop_the_latest_wins():
    """A loop whose clock the test holds: what is asked for in one tick is drawn once, with the last value."""
    seen, asked = [], []
    latest = 0

    async def drag() -> None:
        nonlocal latest
        loop = asyncio.get_running_loop()
        loop.call_later = lambda wait, act: asked.append((wait, act)) or SimpleNamespace(cancel=lambda: None)
        paced = Throttled(lambda: seen.append(latest))
        for latest in range(1, 51):  # noqa: B007 — read by what is paced
            paced()
        assert len(asked) == 1
        assert asked[0][0] == 0.0
        asked[0][1]()
        paced()

    asyncio.run(drag())
    assert seen == [50]
    assert len(asked) == 2
    assert 0.0 < asked[1][0] <= SHORTEST_WAIT


class Shown(OncePerCell, ipywidgets.HTML):
    """Something a cell can show."""


def test_a_cell_that_runs_again_closes_what_it_showed(monkeypatch):
    parent = {"metadata": {"cellId": "cell"}, "header": {"msg_id": "first"}}
    monkeypatch.setattr(IPython, "get_ipython", lambda: SimpleNamespace(get_parent=lambda: parent))
    one, two, three = Shown(), Shown(), Shown()
    one._repr_mimebundle_()
    two._repr_mimebundle_()
    assert one.comm is not None  # two of one run live side by side
    parent["header"] = {"msg_id": "second"}
    two._repr_mimebundle_()
    assert one.comm is None
    assert two.comm is not None  # what is shown again lives on
    parent["metadata"] = {"cellId": "another"}
    three._repr_mimebundle_()
    assert two.comm is not None


def test_what_a_page_says_of_a_closed_widget_is_not_logged(caplog):
    """JupyterLab showed a red 25 at every opening of a Studio."""
    manager, box = get_comm_manager(), ipywidgets.VBox([ipywidgets.Label()])
    gone = box.children[0].model_id
    close_family(box)
    box.close()
    for ident in (gone, "never-there"):
        manager.comm_msg(None, None, {"content": {"comm_id": ident, "data": {}}})
    assert [record.getMessage() for record in caplog.records] == ["No such comm: never-there"]
