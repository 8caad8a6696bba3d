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
from mechstyle.fea.permanent_set import VOLUME
from mechstyle.loop.history import Row, Step, largest_mask_change, rows, standing, steps
from mechstyle.pictures.panels import Picture, picture
from mechstyle.records import Recipe, Verdict, sentences
from mechstyle.records.landings import STANDARDS
from mechstyle.records.material import SPREAD, Material
from mechstyle.records.recipe import described
from mechstyle.runs.report.markup import (
    IN_A_REPORT,
    Markup,
    badge,
    bundle,
    cells,
    fill,
    joined,
    kind,
    legend,
    script_json,
    static,
    table,
    with_code,
)
from mechstyle.runs.report.replay_data import ReplayData, impacts, replay_data, work_out
from mechstyle.runs.report.reproduce import command_for
from mechstyle.runs.report.result import result_element
from mechstyle.runs.report.run_protocol import LaneOfRun, begun
from mechstyle.runs.report.timeline import timeline

LIMITS = (
    "The verdict compares falls and loads in a simulation. It is no certificate: do not rely on it where somebody can get hurt.",
    "The part is solid and isotropic, elastic and then plastic: no layers without a build direction, no infill, fatigue or creep.",
    f"A length stays bent where more than {VOLUME:.0f} mm³ of the part does; smaller dents do not count.",
    "It cracks where the plastic strain in tension exceeds the elongation at break; how a crack runs on is not computed.",
    "Plastics yield later in a fall than in the slow tests that their figures come from: what stays bent is on the safe side.",
    "Where more than the tolerance stays bent of the plain part itself, the styled part is compared with it.",
    "A fall or a load closer to what is allowed than a mesh made anew moves it is not sure.",
    "The largest stress of an element, which the published rule looks at, depends on the mesh where the floor meets the part at a point.",
    "A drop hardly notices walls that are merely too thin to print or to handle. Look at the wall thickness too.",
    "Between simulations stress, bend and mask shown are those of the last one.",
)
"""Limits of the method."""

METHOD = "Faruqi et al., MechStyle (SCF 2025), doi 10.1145/3745778.3766655"
"""Where it comes from."""

TOOLS = ("numpy", "scipy", "trimesh", "manifold3d", "pytetwild", "warp-lang")
"""Libraries whose version can change a figure."""


def write_report(run: LaneOfRun, path: str | Path, *, impact: bool = False) -> Path:
    """Write the report of a lane to a file; `impact` drops the part once more where that has not been done, to show how it lands.

    BadInput if the path is no `.html` file, or the lane has no checkpoint yet.
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
    """The report of a lane, finished or not, as HTML text; BadInput if the lane has no checkpoint yet."""
    history = begun(run)
    passed_steps, played, (impact, impact_payloads) = steps(run.store, history), replay_data(run), _impact(impacts(run))
    script = Markup(f"\n{bundle(static('report.js'), IN_A_REPORT)}\n")
    model, needed = run.record.origin.model, ""
    if not model:
        needed = f"The run was begun from a mesh in memory: save it as {run.record.stem}.stl first. "
    elif not model.startswith("gallery:"):
        needed = f"It needs the file {model} in the folder where it is typed. "
    settings = [
        (name.replace("_", " "), _readable(value), with_code(described(name)))
        for name, value in run.recipe.settings.items()
        if name != "material"  # in a table of its own
    ]
    return fill(
        static("page.html"),
        script_digest=_source(script),
        title=f"{run.record.name}, “{run.recipe.style.prompt}”",
        style=Markup(static("report.css") + static("player.css")),
        head=_head(run, history, len(passed_steps) - 1),
        verdict=_untested(history[-1]) if history[-1].verdict is None else _verdict(history[-1].verdict),
        figures=_figures(run, history),
        still=still(run),
        legend=legend(),
        chart=timeline(passed_steps, history[-1].iteration),
        story=_story(passed_steps, standing(history)[0]),
        notes=_notes(run),
        settings=table(("setting", "value", "what it is"), settings, "Settings"),
        material=_material(run.recipe.test.material),
        limits=joined(fill("<li>{text}</li>", text=text) for text in _limits(run.recipe)),
        method=METHOD,
        command=command_for(run, history),
        missing=needed,
        versions=_versions(run),
        impact=impact,
        impact_payloads=impact_payloads,
        result=result_element(run, standing(history)[1]),
        replay_header=script_json(played.header),
        replay_payload=_payload(played),
        script=script,
    )


def _source(script: str) -> str:
    """What a Content-Security-Policy calls a script by: no other one runs on the page, whatever came to stand in it."""
    return f"sha256-{base64.b64encode(hashlib.sha256(script.encode()).digest()).decode('ascii')}"


def _payload(played: ReplayData) -> Markup:
    return Markup(base64.b64encode(played.payload).decode("ascii"))


def _impact(struck: Sequence[ReplayData]) -> tuple[Markup, Markup]:
    """The section of the impacts, and what they are made of, as scripts that are none; "" and "" if there is none to show."""
    if not struck:
        return Markup(""), Markup("")
    names = enumerate(one.header["name"] for one in struck)
    options = joined(fill('<option value="{number}">{name}</option>', number=number, name=name) for number, name in names)
    section = fill(
        '<section aria-labelledby="h-impact" class="played"><h2 id="h-impact">The impact</h2>'
        '<p><label>Landing <select id="impact-choice">{options}</select></label></p>'
        '<div id="impact" role="group" aria-label="Impact"></div></section>',
        options=options,
    )  # fmt: skip
    headers = fill('<script type="application/json" id="impact-headers">{all}</script>', all=script_json([one.header for one in struck]))
    payloads = [
        fill('<script type="text/plain" id="impact-payload-{number}">{payload}</script>', number=number, payload=_payload(one))
        for number, one in enumerate(struck)
    ]
    return section, joined([headers, *payloads])


def _head(run: LaneOfRun, history: Sequence[Row], simulations: int) -> Markup:
    last = history[-1].iteration
    stands = "finished" if run.finished else f"stands at iteration {last} of {run.recipe.schedule.iterations}"
    return fill(
        '<p class="kicker">MechStyle report</p><h1>{name}<span class="prompt"> as “{prompt}”</span></h1>'
        '<p class="facts">{material} · {iterations} iterations · {simulations} simulations · lane {lane}, {stands}</p>',
        name=run.record.name.replace("_", " "), prompt=run.recipe.style.prompt, material=run.recipe.test.material.label,
        iterations=last, simulations=simulations, lane=run.lane, stands=stands,
    )  # fmt: skip


def _untested(last: Row) -> Markup:
    """The head of a lane that stopped at a surface that was not tested."""
    words = f"{sentences.untested(last.simulated_at)}: go on with the run to have this surface dropped"
    return fill('<p class="verdict unknown"><span><strong>{words}</strong></span></p>', words=words)


def _verdict(verdict: Verdict) -> Markup:
    """The head of the verdict, the table of tests, what is in doubt, and how it came about."""
    headings, rows = sentences.tabulated(verdict)
    shown = [(*cells[:-1], badge(row.outcome, sure=row.sure)) for row, cells in zip(verdict.rows, rows, strict=True)]
    doubt = fill('<p class="unknown">{doubt}</p>', doubt=verdict.doubt) if verdict.doubt else Markup("")
    meanings = joined(
        fill("<dt>{outcome}</dt><dd>{meaning}</dd>", outcome=badge(outcome), meaning=meaning)
        for outcome, meaning in sentences.MEANINGS.items()
    )
    return fill(
        '<p class="verdict {kind}"><span><strong>{outcome}</strong>{rest}</span></p>{rows}{doubt}'
        "<details><summary>How a part is judged</summary><p>{explanation}</p><dl>{meanings}</dl></details>",
        kind=kind(verdict.outcome), outcome=verdict.outcome, rest=verdict.head.removeprefix(verdict.outcome),
        rows=table(headings, shown, "Falls and loads", "tests") if shown else Markup(""),
        doubt=doubt, explanation=" ".join(sentences.EXPLANATION), meanings=meanings,
    )  # fmt: skip


def _figures(run: LaneOfRun, history: Sequence[Row]) -> Markup:
    """The figures one looks for first, beside the verdict."""
    now = history[-1]
    worst = None if now.verdict is None else now.verdict.deciding
    shown = [("stays bent", "–", "this surface was not tested" if now.verdict is None else "the test gave no answer")]
    if worst is not None:
        name = "stays bent" if worst.stress is None else "largest stress"
        where = ", ".join(filter(None, (sentences.label(worst), worst.place, f"{sentences.allowed(worst)} allowed")))
        shown = [(name, sentences.found(worst), where)]
    shown.append(("held back", f"{now.share:.0%}", f"{now.restrained} of {now.vertices} vertices"))
    if run.part.mass_gained:
        shown.append(("thickened first", f"{run.part.mass_gained:+.1f} g", "before the style: the plain part here is the thickened one"))
    if run.finished:
        shown.append(("style kept", f"{run.summary.kept:.0%}", "of the relief that can be seen"))
    return joined(
        fill("<div><dt>{name}</dt><dd>{value}</dd><dd class='faint'>{more}</dd></div>", name=name, value=value, more=more)
        for name, value, more in shown
    )


def _story(passed_steps: Sequence[Step], last: Row) -> Markup:
    """The history of the mask up to what is delivered: a sentence, then every simulation."""
    jump = largest_mask_change(passed_steps)
    sentence = f"{last.restrained} of {last.vertices} vertices ({last.share:.0%}) ended up held back by more than half. "
    sentence += f"{passed_steps[0].restrained} were so from the start: by the stress of the plain part, or because they are protected. "
    sentence += (
        f"The largest step was at iteration {jump.iteration}, which restrained {jump.added} more."
        if jump
        else "No simulation restrained any more of them."
    )
    rows = joined(
        fill('<tr data-iteration="{at}" tabindex="0">{cells}</tr>', at=step.iteration, cells=cells(_row(step))) for step in passed_steps
    )
    return fill(
        '<p>{sentence}</p><div class="scroll"><table class="steps">'
        "<caption>Simulations, and what they restrained; a click shows the iteration</caption>"
        '<thead><tr><th scope="col">iteration</th><th scope="col">why it was simulated</th><th scope="col">outcome</th>'
        '<th scope="col">worst test</th><th scope="col">held back</th><th scope="col">newly</th></tr></thead>'
        "<tbody>{rows}</tbody></table></div>",
        sentence=sentence, rows=rows,
    )  # fmt: skip


def _row(step: Step) -> tuple[object, ...]:
    outcome, held = badge(step.outcome, sure=step.verdict.sure), f"{step.restrained} ({step.share:.1%})"
    return step.iteration, step.reason, outcome, _worst(step), held, step.added


def _notes(run: LaneOfRun) -> Markup:
    notes = run.summary.notes if run.finished else run.part.notes
    if not notes:
        return Markup("")
    items = joined(fill("<li>{note}</li>", note=with_code(note)) for note in notes)
    return fill('<section aria-labelledby="h-notes"><h2 id="h-notes">Notes</h2><ul class="notes">{items}</ul></section>', items=items)


def _readable(value: object) -> object:
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
    material, layers, standard, own = recipe.test.material, recipe.test.layers_judged, recipe.test.after_standard, []
    if material.label != material.name:
        own.append(f"The figures are those of {material.label}; what is sold under the name lies apart ({SPREAD[material.name]}).")
    if layers:
        own.append(f"{layers[0].upper()}{layers[1:]}.")
    if standard:
        departs = STANDARDS[recipe.test.standard].departs
        own.append(f"{standard[0].upper()}{standard[1:]}. {departs} The verdict is no test to the standard.")
    return [*LIMITS, *own]


def _material(material: Material) -> Markup:
    source = f" ({material.layer_source})" if material.layer_source else ""
    layers = "not known" if material.layer_ratio is None else f"{material.layer_ratio:g} of that along them{source}"
    rows = (
        ("Young's modulus E", f"{material.youngs_modulus:g} MPa"),
        ("Poisson's ratio ν", f"{material.poisson_ratio:g}"),
        ("density ρ", f"{1000 * material.density:g} g/cm³"),
        ("yield strength", f"{material.yield_strength:g} MPa"),
        ("hardening past yield", f"{material.hardening:g} MPa"),
        ("elongation at break", f"{material.elongation:.1%}"),
        ("safety coefficient λ_s (published criterion)", f"{material.safety_coefficient:g}"),
        ("strength across printed layers", layers),
    )
    sources = "; ".join(one.rstrip(".") for one in (material.source, material.yielding_source) if one)
    source = fill('<p class="faint">Source of the figures of {name}: {sources}.</p>', name=material.name, sources=sources)
    return joined([table(("property", "value"), rows, f"Material {material.name}"), source])


def _versions(run: LaneOfRun) -> Markup:
    recipe, specimen = run.recipe, run.recipe.test.specimen
    digests = {"recipe (SHA-256)": recipe.digest, "surface": specimen.surface, "tetrahedra": specimen.tetrahedra}
    rows: list[tuple[str, object]] = [
        *((name, fill('<span class="digest">{digest}</span>', digest=digest)) for name, digest in digests.items()),
        ("mechstyle", version("mechstyle")),
        ("Python", platform.python_version()),
        *((name, version(name)) for name in TOOLS),
    ]
    if run.finished:
        rows.insert(3, ("simulated on", run.summary.device))
    return table(("of", "value"), rows, "Digests and versions")


def mimebundle(run: LaneOfRun) -> dict[str, str]:
    """The forms a notebook chooses from; text only before the first checkpoint."""
    history = rows(run.store, run.lane)
    if not history:
        return {"text/plain": repr(run)}
    last, lines, cells = history[-1], list[str](), list[tuple[object, ...]]()
    words = last.words or sentences.untested(last.simulated_at)
    for step in steps(run.store, history):
        outcome = sentences.marked(step.outcome, sure=step.verdict.sure)
        lines.append(f"{step.iteration:>5}  {outcome:<19}  {_worst(step)}  {step.reason}")
        cells.append((step.iteration, step.reason, outcome, _worst(step), f"{step.share:.0%}"))
    html = fill(  # no style sheet and no script, which such places strip
        "<p><strong>{name}</strong> as “{prompt}”</p>{picture}<p>{words}</p>{rows}",
        name=run.record.name, prompt=run.recipe.style.prompt, picture=still(run), words=words,
        rows=table(("iteration", "why it was simulated", "outcome", "worst test", "held back"), cells, "Simulations"),
    )  # fmt: skip
    return {"text/plain": "\n".join([repr(run), words, *lines]), "text/html": html}


def still(run: LaneOfRun) -> Markup:
    """The plain part, then styled, stressed, bent and restrained, as images that carry their own bytes."""
    from mechstyle.pictures.figure import Panel  # noqa: PLC0415 — matplotlib is loaded when a picture is wanted

    return joined(
        [
            _image(picture([Panel(run.part.surface, "plain part")]), "The plain part"),
            _image(run.show(), f"The part as {run.recipe.style.prompt}, its stress, what stays bent and its restraint"),
        ]
    )


def _image(shown: Picture, words: str) -> Markup:
    data = Markup(base64.b64encode(shown.png).decode("ascii"))
    return fill('<img src="data:image/png;base64,{data}" alt="{words}">', data=data, words=words)


def _worst(step: Step) -> str:
    """The worst test, what it found and what it allows; a dash without an answer."""
    decides = step.verdict.deciding
    return "–" if decides is None else sentences.figures(decides)
