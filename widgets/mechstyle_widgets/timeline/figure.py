"""The picture of a timeline: a fixed set of traces, filled anew from the rows of every lane.

It is made of plain dictionaries: plotly's own objects check every value they are given, which for a run of 120 iterations kept the
kernel for 30 ms each time (CPU; 1 ms so), and take a third of a second to load.
Outcomes differ by shape as well as by colour. Whatever can be clicked carries the name of its lane as custom data.
"""

from __future__ import annotations

import json
import textwrap
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from html import escape
from importlib.resources import files
from typing import Any

from mechstyle.loop import correction
from mechstyle.loop.history import Branch, Row
from mechstyle.records import sentences
from mechstyle.simulation.estimate import Plan
from mechstyle_widgets.jupyter.language import said, word
from mechstyle_widgets.state.outcomes import DOUBT, LOOKS
from mechstyle_widgets.state.studio_state import called

TEMPLATES = {"light": "plotly_white", "dark": "plotly_dark"}
PAPER = {"light": "#ffffff", "dark": "#26272b"}
GROUND = {"light": "#ffffff", "dark": "#111111"}
"""Those of JupyterLab's themes, so that a figure held in one of them can be read in a notebook of the other."""
BEYOND = {"light": "#b3261e", "dark": "#ff8a80"}  # of small words, 4.5:1 at least
INK, FAINT = "#1f7a8c", "rgba(140,140,140,0.45)"
LANE, BEND, MARGINS = 22, 72, 48  # heights [pixels]
LEFT, RIGHT = 96, 12  # beside the axes [pixels]
LINE, LETTER = 52, 6.6
"""Letters of the longest line of words, and how wide one is at most on average [pixels]."""

Rows = Sequence[Row]


def filled(traces: Iterable[Mapping[str, Any]], layout: Mapping[str, Any]) -> tuple[list[dict[str, Any]], dict[str, Any]]:
    """Data and layout as plotly's scripts read them; what the layout does not name stays as in an empty figure."""
    empty = _empty()
    data = [{**trace, **content} for trace, content in zip(empty["data"], traces, strict=True)]
    return data, {name: _over(empty["layout"].get(name), layout.get(name)) for name in {**empty["layout"], **layout}}


def _over(kept: Any, new: Any) -> Any:
    if isinstance(kept, dict) and isinstance(new, dict):
        return {**kept, **new}
    return kept if new is None else new


@cache
def template(theme: str) -> dict[str, Any]:
    """What plotly's template for a theme says, as its scripts read it."""
    said: dict[str, Any] = json.loads(plotly_file(f"templates/{TEMPLATES[theme]}.json"))
    return said


def plotly_file(name: str) -> str:
    """A file that plotly brings for its scripts."""
    return (files("plotly") / "package_data" / name).read_text(encoding="utf-8")


@cache
def _empty() -> dict[str, Any]:
    """The figure with all its traces, none of them filled: lanes above, what stays bent below, over the same iterations."""
    above: dict[str, Any] = {"type": "scatter", "xaxis": "x", "yaxis": "y"}
    below: dict[str, Any] = {"type": "scatter", "xaxis": "x2", "yaxis": "y2"}
    line = {"mode": "lines", "hoverinfo": "skip", "showlegend": False}
    across, up = {"domain": [0.0, 1.0], "fixedrange": True, "zeroline": False}, {"fixedrange": True, "zeroline": False, "automargin": False}
    rule = {"type": "line", "xref": "x", "yref": "paper", "x0": 0, "x1": 0, "y0": 0, "y1": 1, "line": {"color": "#e08e0b", "width": 2}}
    return {
        "data": [
            {**above, **line, "line": {"color": FAINT, "width": 2}},
            {**above, "mode": "markers", "showlegend": False},
            *({**above, "mode": "markers", "name": outcome} for outcome in LOOKS),
            {**below, **line, "line": {"color": FAINT, "width": 1.5}},
            {**below, **line, "line": {"color": LOOKS["FAILS"].line, "width": 1.5, "dash": "dash"}},
            {**below, "mode": "lines+markers", "line": {"color": INK, "width": 1.5}, "showlegend": False},
            {**above, "mode": "lines+markers", "name": "planned", "line": {"color": FAINT, "width": 2}},
        ],
        "layout": {
            "xaxis": {"anchor": "y", "matches": "x2", "showticklabels": False, **across},
            "yaxis": {"anchor": "x", **up},
            "xaxis2": {"anchor": "y2", **across},
            "yaxis2": {"anchor": "x2", **up},
            "margin": {"l": LEFT, "r": RIGHT, "t": 18, "b": 30},
            "font": {"size": 11},
            "legend": {"orientation": "h", "x": 1.0, "xanchor": "right", "y": 1.02, "yanchor": "bottom", "itemclick": False},
            "shapes": [rule],
            "dragmode": False,
            "hovermode": "closest",
            "paper_bgcolor": "rgba(0,0,0,0)",
            "plot_bgcolor": "rgba(0,0,0,0)",
        },
    }


def contents(
    histories: Mapping[str, Rows], branches: Sequence[Branch], lane: str, theme: str
) -> tuple[list[dict[str, Any]], dict[str, Any]]:
    """Contents of the traces and the layout that goes with them, for `filled`."""
    forks = {branch.lane: (branch.forked_at, branch.parent or branch.lane) for branch in branches if branch.forked_at is not None}
    own = {name: [row for row in rows if name not in forks or row.iteration > forks[name][0]] for name, rows in histories.items()}
    others = {name: rows for name, rows in own.items() if name != lane}
    shown, names = {lane: histories.get(lane, [])}, called(branches)
    traces = [
        *_lanes(own, forks, names),
        _lines(others, lambda row: figures(row)[0]),
        _lines(shown, lambda row: figures(row)[1]),
        _worst(lane, shown[lane], names),
        _planned(lane, ()),
    ]
    layout = _layout(list(histories), names, lane, theme, max((branch.iterations for branch in branches), default=1))
    notes = []
    for row in reversed(shown[lane]):
        if row.verdict is not None and (decides := row.verdict.deciding) is not None:
            # in words, above the end of its line and off the upright one that may be there
            early = 2 * row.iteration < layout["xaxis"]["range"][1]  # there is no room at the left of it
            place = {"x": row.iteration, "xref": "x", "xanchor": "left" if early else "right", "y": figures(row)[1], "yref": "y2"}
            look = {"showarrow": False, "font": {"size": 10, "color": BEYOND[theme]}, "xshift": 8 if early else -8, "yanchor": "bottom"}
            notes.append({"text": said(f"allowed {sentences.allowed(decides)}"), **look, **place})
            layout["yaxis2"]["title"] = {"text": "[mm]" if decides.stress is None else "[MPa]"}
            break
    return traces, {**layout, "annotations": notes}


def figures(row: Row) -> tuple[float | None, float | None]:
    """What the test that decides found and what it allows [mm, or MPa by the published rule]; None where there is no answer."""
    decides = None if row.verdict is None else row.verdict.deciding
    if decides is None:
        return None, None
    return (decides.permanent_set, decides.allowed) if decides.stress is None else (decides.stress, decides.limit)


def before(plan: Plan | None, lane: str, theme: str, width: int) -> tuple[list[dict[str, Any]], dict[str, Any]]:
    """As `contents`, for a run without an iteration, in a figure so wide [pixels]; the plan is None if it is not known."""
    places = (0, *plan.places) if plan else ()
    traces, layout = contents({lane: []}, [], lane, theme)
    text = word("Nothing has run yet.")
    if plan is not None:
        text = word("Nothing has run yet. The part will be dropped at the hollow marks.")
        text += "" if plan.certain else " " + word("They may move: the run decides.")
    letters = min(max(int((width - LEFT - RIGHT) / LETTER), 12), LINE)  # of a line that fits between the axes
    words = {"text": "<br>".join(textwrap.wrap(text, letters)), "showarrow": False, "font": {"size": 12}}
    middle = {"x": 0.5, "xref": "paper", "xanchor": "center", "y": 0.5, "yref": "y2 domain", "yanchor": "middle"}
    empty_axes = {"yaxis2": {**layout["yaxis2"], "showticklabels": False}}
    ranges = {axis: _range(places[-1] if places else 1) for axis in ("xaxis", "xaxis2")}
    return [*traces[:-1], _planned(lane, places)], {**layout, **empty_axes, **ranges, "annotations": [{**words, **middle}]}


def _planned(lane: str, places: Sequence[int]) -> dict[str, Any]:
    marker = {"symbol": "circle-open", "color": LOOKS["UNKNOWN"].line, "size": 9}
    hover = {"hovertemplate": word("drop test planned at iteration %{x}") + "<extra></extra>"}
    return {"x": list(places), "y": [lane] * len(places), "name": word("planned"), "marker": marker, **hover}


def _lanes(own: Mapping[str, Rows], forks: Mapping[str, tuple[int, str]], names: Mapping[str, str]) -> list[dict[str, Any]]:
    """The lines of the lanes from where they fork, their iterations, and their simulations by outcome."""
    flat = [(name, row) for name, rows in own.items() for row in rows]
    lines: list[tuple[float | None, str]] = []
    for name, rows in own.items():
        start = [forks[name], (forks[name][0], name)] if name in forks else []
        gap = (None, name)  # with its name: plotly tells the kind of an axis anew from the first values it meets, and none are no names
        lines += [*start, *((row.iteration, name) for row in (*rows[:1], *rows[-1:])), gap]
    traces = [{"x": [x for x, _ in lines], "y": [y for _, y in lines]}, {**_marks(flat, names), "marker": {"size": 16, "opacity": 0.0}}]
    for outcome, look in LOOKS.items():
        of_this = [(name, row) for name, row in flat if row.outcome == outcome]
        marker = {"symbol": look.symbol, "color": look.line, "size": 9, "line": _around(of_this)}
        traces.append({**_marks(of_this, names), "name": word(outcome), "marker": marker})
    return traces


def _marks(flat: Sequence[tuple[str, Row]], names: Mapping[str, str]) -> dict[str, Any]:
    return {
        "x": [row.iteration for _, row in flat],
        "y": [name for name, _ in flat],
        "customdata": [[name] for name, _ in flat],
        "hovertext": [story(names.get(name, name), row) for name, row in flat],
        "hoverinfo": "none",  # the page says it under the chart, which stays in sight
    }


def _lines(lanes: Mapping[str, Rows], value: Any) -> dict[str, Any]:
    """One line for each lane over the rows that have a value, with gaps between them."""
    x: list[float | None] = []
    y: list[float | None] = []
    for rows in lanes.values():
        known = [(row.iteration, value(row)) for row in rows if value(row) is not None]
        x += [*(at for at, _ in known), None]
        y += [*(height for _, height in known), None]
    return {"x": x, "y": y}


def _worst(lane: str, rows: Rows, names: Mapping[str, str]) -> dict[str, Any]:
    """What the test that decides found, a mark for each simulation."""
    marks = [(lane, row) for row in rows if figures(row)[0] is not None]
    looks = [LOOKS[row.outcome] for _, row in marks]
    shape = {"symbol": [look.symbol for look in looks], "color": [look.line for look in looks], "size": 8}
    return {**_marks(marks, names), "y": [figures(row)[0] for _, row in marks], "marker": {**shape, "line": _around(marks)}}


def _around(marks: Sequence[tuple[str, Row]]) -> dict[str, Any]:
    """A line around each mark whose outcome is not sure."""
    return {"color": DOUBT, "width": [2 if row.verdict is not None and row.verdict.doubts else 0 for _, row in marks]}


def story(lane: str, row: Row, last: str = "") -> str:
    """What is said of an iteration, in two lines at most: what came of it, and why it was tested.

    `last` says whose it is where another run is asked for.
    """
    found = sentences.NOT_TESTED if row.verdict is None else " · ".join(filter(None, (row.outcome, sentences.least(row.verdict))))
    whose = " · ".join(filter(None, (said(last), lane, f"{word('iteration')} {row.iteration}")))
    lines = [f"<b>{escape(whose)}</b> · {escape(said(found))}"]
    if row.reason:
        why, corrected = row.reason.removeprefix(correction.REASON), row.reason.startswith(correction.REASON)
        lines.append(escape(said(f"{'corrected' if corrected else 'tested'} after step {row.iteration}: {why}")))
    return "<br>".join(lines)


def _layout(lanes: Sequence[str], known: Mapping[str, str], lane: str, theme: str, iterations: int) -> dict[str, Any]:
    heights = (LANE * max(len(lanes), 1) + 10, BEND)
    inside, gap = sum(heights) + 14, 14 / (sum(heights) + 14)
    bottom, domains = 1.0, []
    for height in heights:
        domains.append([max(bottom - height / inside, 0.0), bottom])
        bottom -= height / inside + gap
    said = {name: escape(known.get(name, name)) for name in lanes}
    names = [f"<b>{said[name]}</b>" if name == lane else said[name] for name in lanes]
    rows = {"categoryorder": "array", "categoryarray": lanes[::-1], "tickmode": "array", "tickvals": lanes, "ticktext": names}
    return {
        "template": template(theme),
        "height": inside + MARGINS,
        "hoverlabel": {"bgcolor": PAPER[theme], "align": "left"},
        "paper_bgcolor": GROUND[theme],
        "plot_bgcolor": "rgba(0,0,0,0)",
        "yaxis": {"domain": domains[0], "type": "category", "range": [-0.6, len(lanes) - 0.4], "showgrid": False, **rows},
        "yaxis2": {"domain": domains[1], "title": {"text": "[mm]"}, "rangemode": "tozero", "nticks": 4, "showticklabels": True},
        "xaxis": _range(iterations),
        "xaxis2": {**_range(iterations), "title": {"text": word("iteration"), "standoff": 2}},
    }


def _range(iterations: int) -> dict[str, Any]:
    return {"range": [-0.02 * iterations, 1.02 * iterations]}
