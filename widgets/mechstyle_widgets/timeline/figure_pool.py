"""Plotly figures that are used again.

Each figure widget brings plotly's scripts with it, 5 MB that a page loads anew for every one and never lets go of, about 20 MB of
memory: figures that were put away are filled anew before another is made.
"""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from typing import Any

from plotly import graph_objects

_idle: list[Any] = []


class Figure(graph_objects.FigureWidget):  # type: ignore[misc]  # plotly has no types
    """A figure widget whose state is what it shows.

    Plotly tells a page of changes by messages and leaves the state as it was at the beginning, from which a page that is loaded anew
    while the kernel goes on would draw it.
    """

    def get_state(self, key: Any = None, drop_defaults: bool = False) -> Any:
        """State of the widget for a page, as ipywidgets asks for it."""
        if key is None and hasattr(self, "_data"):  # not while it is made; and not told to the page that has it already
            self._trait_values |= {"_widget_data": deepcopy(self._data), "_widget_layout": deepcopy(self._layout)}
        return super().get_state(key, drop_defaults)


def taken(make: Callable[[], Any], fill: Callable[[Any], None]) -> Any:
    """A figure widget that is filled, one that was put away if there is one.

    Args:
        make: Makes an empty figure; every figure it makes must have the same traces.
        fill: Puts into a figure, or a figure widget, all in which one may differ from another.
    """
    while _idle:
        figure = _idle.pop()
        if figure.comm is not None:  # else somebody closed all widgets
            with figure.batch_update():
                fill(figure)
            # A view that is made from now on starts from these, which nothing else brings up to date.
            figure._widget_data, figure._widget_layout = deepcopy(figure._data), deepcopy(figure._layout)  # noqa: SLF001 — as plotly does
            return figure
    figure = make()
    fill(figure)  # what is told a figure before the browser has it may get lost
    return Figure(figure)


def put_away(figure: Any) -> None:
    """Keep a figure widget that is shown no longer."""
    for trace in figure.data:
        trace.on_click(None)
    _idle.append(figure)
