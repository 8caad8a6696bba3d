"""The report of a lane as one HTML file that opens offline: everything it shows is inside."""

from __future__ import annotations

import base64
import hashlib
import platform
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path

import msgspec

from mechstyle._files import write_whole
from mechstyle.errors import BadInput
from mechstyle.loop.history import Row, Step, Strength, largest_mask_change, standing, steps
from mechstyle.records import Judgement, Recipe, Verdict
from mechstyle.records.landings import STANDARDS
from mechstyle.records.material import SPREAD, Material
from mechstyle.records.recipe import described
from mechstyle.runs.report import texts
from mechstyle.runs.report.bundle import IN_A_REPORT, bundle, static
from mechstyle.runs.report.impact_data import impacts, work_out
from mechstyle.runs.report.markup import Markup, cells, fill, joined, script_json, table, with_code
from mechstyle.runs.report.replay_data import ReplayData, replay_data
from mechstyle.runs.report.reproduce import command_for
from mechstyle.runs.report.run_protocol import LaneOfRun, begun
from mechstyle.runs.report.static_view import still
from mechstyle.runs.report.timeline import timeline

TOOLS = ("numpy", "scipy", "trimesh", "manifold3d", "pytetwild", "warp-lang")
"""Libraries whose version can change a figure."""


def write_report(run: LaneOfRun, path: str | Path, *, impact: bool = False) -> Path:
    """Write the report of a lane to a file; `impact` drops the part once more where that has not been done, to show how it lands.

    Raises:
        BadInput: If the path is no `.html` file, or the lane has no checkpoint yet.
    """
    target = Path(path)
    if target.suffix.lower() not in {".html", ".htm"} or target.is_dir():
        raise BadInput(f"a report is an HTML file: give {target.with_suffix('.html').name} instead of {target.name}")
    if impact:
        begun(run)
        work_out(run)
    write_whole(target, report_page(run).encode("utf-8"))
    return target


def report_page(run: LaneOfRun) -> str:
    """The report of a lane, finished or not, as HTML text.

    Raises:
        BadInput: If the lane has no checkpoint yet.
    """
    history = begun(run)
    told, played, struck = steps(run.store, history), replay_data(run), impacts(run)
    script = Markup(f"\n{bundle(static('report.js'), IN_A_REPORT)}\n")
    return fill(
        static("page.html"),
        script_digest=_source(script),
        title=f"{run.record.name}, “{run.recipe.prompt}”",
        style=Markup(static("report.css") + static("player.css")),
        head=_head(run, history, len(told) - 1),
        figures=_figures(run, history, told[0].verdict),
        still=still(run),
        rules=_rules(standing(history)[1], told[0].verdict),
        chart=timeline(told, history[-1].iteration),
        story=_story(told, standing(history)[0]),
        notes=_notes(run),
        settings=_settings(run.recipe),
        material=_material(run.recipe.material),
        limits=joined(fill("<li>{text}</li>", text=text) for text in _limits(run.recipe)),
        method=texts.METHOD,
        command=command_for(run, history),
        missing=_missing(run),
        versions=_versions(run),
        impact=_impact(struck),
        impact_payloads=_impact_payloads(struck),
        replay_header=script_json(played.header),
        replay_payload=_payload(played),
        script=script,
    )


def _source(script: str) -> str:
    """What a Content-Security-Policy calls a script by: no other one runs on the page, whatever came to stand in it."""
    return f"sha256-{base64.b64encode(hashlib.sha256(script.encode()).digest()).decode('ascii')}"


def _payload(played: ReplayData) -> Markup:
    return Markup(base64.b64encode(played.payload).decode("ascii"))


def _impact(struck: Sequence[ReplayData]) -> Markup:
    """The section of the impacts, "" if there is none to show."""
    if not struck:
        return Markup("")
    names = enumerate(one.header["name"] for one in struck)
    options = joined(fill('<option value="{number}">{name}</option>', number=number, name=name) for number, name in names)
    return fill(
        '<section aria-labelledby="h-impact" class="played"><h2 id="h-impact">The impact</h2>'
        '<p><label>Landing <select id="impact-choice">{options}</select></label></p>'
        '<div id="impact" role="group" aria-label="Impact"></div></section>',
        options=options,
    )  # fmt: skip


def _impact_payloads(struck: Sequence[ReplayData]) -> Markup:
    """What the impacts are made of, as scripts that are none."""
    if not struck:
        return Markup("")
    headers = fill('<script type="application/json" id="impact-headers">{all}</script>', all=script_json([one.header for one in struck]))
    payloads = [
        fill('<script type="text/plain" id="impact-payload-{number}">{payload}</script>', number=number, payload=_payload(one))
        for number, one in enumerate(struck)
    ]
    return joined([headers, *payloads])


def _head(run: LaneOfRun, history: Sequence[Row], simulations: int) -> Markup:
    last, (_, verdict) = history[-1].iteration, standing(history)
    kind = "marginal" if verdict.marginal else verdict.outcome.lower()
    stands = "finished" if run.finished else f"stands at iteration {last} of {run.recipe.iterations}"
    return fill(
        '<p class="kicker">MechStyle report</p><h1>{name}<span class="prompt"> as “{prompt}”</span></h1>'
        '<p class="facts">{material} · {iterations} iterations · {simulations} simulations · lane {lane}, {stands}</p>'
        '<div class="verdict {kind}"><strong>{outcome}</strong><div><p>{meaning}{marginal}</p><p class="faint">{words}</p></div></div>',
        name=run.record.name.replace("_", " "), prompt=run.recipe.prompt, material=run.recipe.material.label,
        iterations=last, simulations=simulations, lane=run.lane, stands=stands, kind=kind,
        outcome=verdict.told, meaning=texts.OUTCOMES[verdict.outcome], marginal=f" {texts.MARGINAL}" if verdict.marginal else "",
        words=verdict.words,
    )  # fmt: skip


def _figures(run: LaneOfRun, history: Sequence[Row], first: Verdict) -> Markup:
    """The figures one looks for first, `first` being the verdict on the original."""
    now, verdict = standing(history)
    decides, unknown = verdict.deciding, verdict.outcome == "UNKNOWN"
    shown = [
        ("peak stress", "–" if unknown else f"{decides.value:.1f} MPa", f"limit {decides.limit:.1f}, before {first.deciding.value:.1f}"),
        ("safety factor", "–" if unknown else f"{verdict.safety_factor:.2f}", "the least of the rules that count"),
    ]
    spread = verdict.all_orientations
    if spread is not None and not unknown:
        shown.append(("all orientations", f"{spread.value:.2f} ×", f"the original's stress, limit {spread.limit:.2f}"))
    if run.finished:
        shown += _informing(run.summary.baseline, run.summary.result)
    shown.append(("held back", f"{now.share:.0%}", f"{now.restrained} of {now.vertices} vertices"))
    if run.part.mass_gained:
        shown.append(("thickened first", f"{run.part.mass_gained:+.1f} g", "before the style: the original here is the thickened part"))
    if run.finished:
        shown.append(("relief kept", f"{run.summary.kept:.0%}", "of what the style alone would have made"))
    return joined(
        fill("<div><dt>{name}</dt><dd>{value}</dd><dd class='faint'>{more}</dd></div>", name=name, value=value, more=more)
        for name, value, more in shown
    )


def _informing(before: Strength, now: Strength) -> list[tuple[str, str, str]]:
    """What decides nothing but tells what a fall may do: the worst landing, and how many random drops begin to yield the part."""
    shown = []
    if now.worst is not None and before.worst is not None:
        shown.append(("worst landing", f"{now.worst:.0f} MPa", f"{now.worst_landing}; the original {before.worst:.0f}"))
    if now.failure_probability is not None and before.failure_probability is not None:
        more = f"of random drops; the original in {before.failure_probability:.0%}"
        shown.append(("begins to yield", f"{now.failure_probability:.0%}", more))
    return shown


def _rules(now: Verdict, first: Verdict) -> Markup:
    """Each rule applied to the styled part and to the original."""
    rows: list[tuple[str, Judgement, Judgement | None]] = [("as placed", now.as_placed, first.as_placed)]
    if now.tilted is not None:
        rows.append(("tilted by 3°", now.tilted, first.tilted))
    if now.all_orientations is not None:
        rows.append(("all orientations", now.all_orientations, first.all_orientations))
    rows.append(("published rule", now.literal, first.literal))
    return table(
        ("test", "rule", "counts", "outcome", "now", "original", "limit"),
        [
            (
                name, judged.rule, "yes" if judged in now.counting else "shown only",
                _badge(judged.outcome, marginal=judged.marginal), _value(judged),
                "–" if before is None else _value(before), _figure(judged.limit, judged.unit),
            )
            for name, judged, before in rows
        ],
        "Verdicts",
        "rules",
    )  # fmt: skip


def _badge(outcome: str, *, marginal: bool) -> Markup:
    kind = "marginal" if marginal else outcome.lower()
    return fill('<span class="{kind}">{outcome}</span>{more}', kind=kind, outcome=outcome, more=", marginal" if marginal else "")


def _value(judged: Judgement) -> str:
    return "–" if judged.outcome == "UNKNOWN" else _figure(judged.value, judged.unit)


def _figure(value: float, unit: str) -> str:
    """A number with as many digits as are significant."""
    return f"{value:.1f} MPa" if unit == "MPa" else f"{value:.2f} {unit}"


def _story(told: Sequence[Step], last: Row) -> Markup:
    """The history of the mask up to what is delivered: a sentence, then every simulation."""
    jump = largest_mask_change(told)
    sentence = f"{last.restrained} of {last.vertices} vertices ({last.share:.0%}) ended up held back by more than half. "
    sentence += f"{told[0].restrained} were so from the start: by the stress of the original part, or because they are protected. "
    sentence += (
        f"The largest step was at iteration {jump.iteration}, which restrained {jump.added} more."
        if jump
        else "No simulation restrained any more of them."
    )
    rows = joined(
        fill('<tr data-iteration="{at}" tabindex="0">{cells}</tr>', at=step.iteration, cells=cells(_row(step))) for step in told
    )
    return fill(
        '<p>{sentence}</p><div class="scroll"><table class="steps">'
        "<caption>Simulations, and what they restrained; a click shows the iteration</caption>"
        '<thead><tr><th scope="col">iteration</th><th scope="col">why it was simulated</th><th scope="col">verdict</th>'
        '<th scope="col">peak [MPa]</th><th scope="col">held back</th><th scope="col">newly</th></tr></thead>'
        "<tbody>{rows}</tbody></table></div>",
        sentence=sentence, rows=rows,
    )  # fmt: skip


def _row(step: Step) -> tuple[object, ...]:
    badge = _badge(step.outcome, marginal=step.verdict.marginal)
    peak = "–" if step.peak is None else f"{step.peak:.1f}"
    return step.iteration, step.reason, badge, peak, f"{step.restrained} ({step.share:.1%})", step.added


def _notes(run: LaneOfRun) -> Markup:
    notes = run.summary.notes if run.finished else run.part.notes
    if not notes:
        return Markup("")
    return fill('<ul class="notes">{items}</ul>', items=joined(fill("<li>{note}</li>", note=with_code(note)) for note in notes))


def _settings(recipe: Recipe) -> Markup:
    return table(
        ("setting", "value", "what it is"),
        [
            (name.replace("_", " "), _plain(value), with_code(described(name)))
            for name, value in recipe.settings.items()
            if name != "material"  # in a table of its own
        ],
        "Settings",
    )


def _plain(value: object) -> object:
    """A setting as a reader expects it; structures become JSON."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, str):
        return value or "none"
    if isinstance(value, int | float):
        return f"{value:g}"
    return msgspec.json.encode(value).decode() if value else "none"


def _limits(recipe: Recipe) -> list[str]:
    """Limits of the method, and those of the material and the standard of this run."""
    material, own = recipe.material, []
    if material.label != material.name:
        own.append(f"The figures are those of {material.label}; what is sold under the name lies apart ({SPREAD[material.name]}).")
    if recipe.layers_judged:
        own.append(f"{recipe.layers_judged[0].upper()}{recipe.layers_judged[1:]}.")
    if recipe.standard:
        words = f"{recipe.after_standard[0].upper()}{recipe.after_standard[1:]}"
        own.append(f"{words}. {STANDARDS[recipe.standard].departs} The verdict is no test to the standard.")
    return [*texts.LIMITS, *own]


def _material(material: Material) -> Markup:
    rows = (
        ("Young's modulus E", f"{material.youngs_modulus:g} MPa"),
        ("Poisson's ratio ν", f"{material.poisson_ratio:g}"),
        ("density ρ", f"{1000 * material.density:g} g/cm³"),
        ("yield strength", f"{material.yield_strength:g} MPa"),
        ("safety coefficient λ_s (published criterion)", f"{material.safety_coefficient:g}"),
        ("strength across printed layers", _across_layers(material)),
    )
    source = fill('<p class="faint">Source of the figures of {name}: {source}.</p>', name=material.name, source=material.source.rstrip("."))
    return joined([table(("property", "value"), rows, f"Material {material.name}"), source])


def _across_layers(material: Material) -> str:
    """The ratio of strengths with its source."""
    if material.layer_ratio is None:
        return "not known"
    return f"{material.layer_ratio:g} of that along them" + (f" ({material.layer_source})" if material.layer_source else "")


def _missing(run: LaneOfRun) -> str:
    """Preconditions of the command, in words: files or plug-ins it needs."""
    model = run.record.origin.model
    if not model:
        return f"The run was begun from a mesh in memory: save it as {run.record.stem}.stl first. "
    return "" if model.startswith("gallery:") else f"It needs the file {model} in the folder where it is typed. "


def _digest(digest: str) -> Markup:
    return fill('<span class="digest">{digest}</span>', digest=digest)


def _versions(run: LaneOfRun) -> Markup:
    recipe = run.recipe
    rows: list[tuple[str, object]] = [
        ("recipe (SHA-256)", _digest(recipe.digest)),
        ("surface", _digest(recipe.surface)),
        ("tetrahedra", _digest(recipe.tetrahedra)),
        ("mechstyle", version("mechstyle")),
        ("Python", platform.python_version()),
        *((name, version(name)) for name in TOOLS),
    ]
    if run.finished:
        rows.insert(3, ("simulated on", run.summary.device))
    return table(("of", "value"), rows, "Digests and versions")
