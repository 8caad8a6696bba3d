"""Commands that style a part: run, freestyle, branch."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from mechstyle.cli.console import command, err, escape, factor, out, print_json, table, telling, verdict_text
from mechstyle.errors import BadInput
from mechstyle.records import CONTROLS, CRITERIA, FIELDS, GUIDANCES, NORMALISATIONS, POSES, SCHEDULES

Model = Annotated[str, typer.Argument(metavar="MODEL", help="A file (STL, OBJ, PLY, GLB, 3MF) or gallery:NAME.")]
Prompt = Annotated[str, typer.Option("--prompt", "-p", help="The style, in words.")]
MaterialName = Annotated[
    str, typer.Option("--material", "-m", help="A library material (see `mechstyle materials`) or a .toml/.json file.")
]
Control = Annotated[str | None, typer.Option(help=f"How stress restrains: {', '.join(CONTROLS)}.")]
Normalisation = Annotated[str | None, typer.Option(help=f"What stress is compared with: {', '.join(NORMALISATIONS)}.")]
Threshold = Annotated[float | None, typer.Option(help="Demand at which a vertex may move no further; 1 is the limit, less is stricter.")]
Schedule = Annotated[str | None, typer.Option(help=f"When to simulate: {', '.join(SCHEDULES)}.")]
Every = Annotated[int | None, typer.Option(help="Interval of the schedule `every` [iterations].")]
Iterations = Annotated[int | None, typer.Option(help="Stylization iterations.")]
Seed = Annotated[int | None, typer.Option(help="Seed of the style.")]
Amplitude = Annotated[float | None, typer.Option(help="Relief height over local wall thickness.")]
Orientations = Annotated[int | None, typer.Option(help="Drops in the final test, the first as placed.")]
Poses = Annotated[str | None, typer.Option(help=f"How the others land (all ways, nearly flat, as it rests): {', '.join(POSES)}.")]
Criterion = Annotated[str | None, typer.Option(help=f"What viable means: {', '.join(CRITERIA)}.")]
LoadFile = Annotated[Path | None, typer.Option("--load", help="A .toml file of load cases the part must carry besides the drop.")]
MinimumWall = Annotated[float | None, typer.Option(help="The thinnest wall the style may leave [mm]; 0 for no rule.")]
Vertices = Annotated[int, typer.Option(help="Vertices of the standardised surface.")]
Scale = Annotated[float | None, typer.Option(help="Multiply the file's coordinates to get millimetres.")]
Device = Annotated[str, typer.Option(help="auto, cpu or cuda.")]
Folder = Annotated[Path | None, typer.Option("--out", help="Run directory; the same command goes on where it stopped.")]
Protect = Annotated[
    bool | None,
    typer.Option("--protect-resting-face/--no-protect-resting-face", help="Fade the relief out towards the face the part rests on."),
]
Regions = Annotated[
    list[str] | None,
    typer.Option(
        "--protect",
        help="A region the style leaves alone: inside, outside, 'box x y z x y z', 'sphere x y z r', 'plane x y z nx ny nz', 'above z', "
        "'below z', 'segment x y z'; then, if wanted, 'ramp MM' and 'colour'. May be given several times.",
    ),
]
Stylizer = Annotated[str | None, typer.Option(help="A plugged-in stylizer instead of the built-in styles.")]
More = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="NAME=VALUE", help="Any other setting of the recipe, such as travel=0.2. May be given several times."),
]
Guidance = Annotated[
    str | None, typer.Option(help=f"What the style descends to: {', '.join(GUIDANCES)} (any prompt; see `mechstyle weights list`).")
]
StyleField = Annotated[str | None, typer.Option("--field", help=f"What is descended in: {', '.join(FIELDS)} (X-Mesh).")]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON object on stdout and nothing else.")]

app = typer.Typer()


def read_model(model: str, scale: float | None, *, quiet: bool) -> tuple[Any, str]:
    """The mesh and the name of a model given on the command line; repairs are reported on stderr."""
    if model.startswith("gallery:"):
        from mechstyle.gallery import make  # noqa: PLC0415 — CSG is loaded when a gallery model is wanted

        name = model.removeprefix("gallery:")
        if scale is not None:
            raise BadInput(f"{model}: --scale is for files; gallery models are in millimetres")
        return make(name), name
    from mechstyle.geometry.files import read  # noqa: PLC0415 — as above, for mesh files

    loaded = read(model, scale=scale)
    if not quiet:
        for note in loaded.notes:
            err.print(f"[dim]{escape(Path(model).name)}: {escape(note)}[/]")
    return loaded.mesh, Path(model).stem


def carry_out(
    model: str,
    prompt: str,
    material: str,
    vertices: int,
    scale: float | None,
    device: str,
    folder: Path | None,
    *,
    freestyle: bool,
    as_json: bool,
    more: list[str] | None = None,
    **settings: Any,
) -> Any:
    """Run a stylization with progress; the finished run, its part exported and pictured."""
    from mechstyle.fea.drop import resolve_device  # noqa: PLC0415 — physics is loaded when something is run
    from mechstyle.runs.recipes import draft  # noqa: PLC0415
    from mechstyle.runs.run import begin, clock_stages, default_folder  # noqa: PLC0415
    from mechstyle.runs.summary import Clock  # noqa: PLC0415
    from mechstyle.simulation.part import Origin, fitted  # noqa: PLC0415
    from mechstyle.styling.prompt import read as read_prompt  # noqa: PLC0415

    wanted = draft(prompt, freestyle=freestyle, **merged(more, material=material, **settings))
    device = resolve_device(device)
    if not as_json and not wanted.stylizer and wanted.guidance == "offline":
        for note in read_prompt(prompt).notes:
            err.print(f"[dim]prompt: {escape(note)}[/]")
    mesh, name = read_model(model, scale, quiet=as_json)
    with telling(wanted.iterations, quiet=as_json) as teller:
        clock = Clock()
        part = clock_stages(clock, teller.stage, mesh, vertices)
        recipe = fitted(wanted, part)
        origin = Origin(model=model if model.startswith("gallery:") else Path(model).name, vertices=vertices, scale=scale)
        where = folder if folder is not None else default_folder(prompt, recipe)
        run = begin(part, recipe, where, name=name, device=device, origin=origin)
        run.clock.add(clock.seconds())
        return finish(run, teller)


def merged(more: list[str] | None, **settings: Any) -> dict[str, Any]:
    """Settings from options of their own, then those given with --set."""
    from mechstyle.runs.recipes import typed  # noqa: PLC0415 — as above

    return settings | dict(typed(text) for text in more or ())


def finish(run: Any, teller: Any) -> Any:
    """Carry a run on to its end, then export and picture the part."""
    teller.stage("simulating the unstylized part")
    run.go(teller.event, teller.fraction)
    teller.stage("writing files")
    stem = f"{run.record.name}-{run.lane}"
    model = run.store.root / f"{stem}.3mf"
    quality = run.exported(model).quality
    run.add_files({"model": model, "picture": run.show().save(run.store.root / f"{stem}.png")}, quality.warnings)
    return run


def report(run: Any, *, as_json: bool) -> None:
    """Print what a run came to."""
    summary = run.summary
    if as_json:
        print_json(summary)
        return
    rows = table("stresses in MPa", "verdict", "peak", "allowed", "safety", "literal max", "all turns")
    for name, strength in (("as it came", summary.baseline), ("styled", summary.result)):
        overall = "–" if strength.all_orientations is None else f"{strength.all_orientations:.2f} x"
        rows.add_row(
            name,
            verdict_text(strength.verdict),
            f"{strength.peak_stress:.1f}",
            f"{strength.allowable:.1f}",
            factor(strength.safety_factor),
            f"{strength.maximum:.1f}",
            overall,
        )
    out.print(rows)
    out.print(f"\n{escape(summary.words)}")
    kept = f"kept {summary.kept:.0%} of the freestyle relief; style loss {summary.style_loss_ratio:.1%} of its start"
    out.print(f"{kept}; {len(summary.simulations)} simulations")
    if summary.failure_probability is not None:
        out.print(f"{summary.failure_probability:.0%} of random drops exceed the yield strength somewhere ({run.recipe.poses})")
    for note in summary.notes:
        out.print(f"[dim]note: {escape(note)}[/]")
    for case in summary.loads:
        out.print(f"load {escape(repr(case.name))}: {case.words}")
    out.print("seconds: " + ", ".join(f"{stage} {value:.1f}" for stage, value in summary.seconds.items()))
    for what, path in summary.files.items():
        out.print(f"{what}: {escape(path)}")


@app.command("run")
@command
def run_command(
    model: Model,
    prompt: Prompt,
    material: MaterialName = "PLA",
    loads: LoadFile = None,
    minimum_wall: MinimumWall = None,
    control: Control = None,
    normalisation: Normalisation = None,
    threshold: Threshold = None,
    schedule: Schedule = None,
    every: Every = None,
    iterations: Iterations = None,
    seed: Seed = None,
    amplitude: Amplitude = None,
    orientations: Orientations = None,
    poses: Poses = None,
    criterion: Criterion = None,
    protect_resting_face: Protect = None,
    protect: Regions = None,
    stylizer: Stylizer = None,
    guidance: Guidance = None,
    field: StyleField = None,
    vertices: Vertices = 25_000,
    scale: Scale = None,
    more: More = None,
    device: Device = "auto",
    folder: Folder = None,
    as_json: Json = False,
) -> None:
    """Style a part while a drop test watches its strength."""
    run = carry_out(
        model,
        prompt,
        material,
        vertices,
        scale,
        device,
        folder,
        freestyle=False,
        as_json=as_json,
        loads=loads,
        minimum_wall=minimum_wall,
        more=more,
        control=control,
        normalisation=normalisation,
        threshold=threshold,
        schedule=schedule,
        every=every,
        iterations=iterations,
        seed=seed,
        amplitude=amplitude,
        orientations=orientations, poses=poses,
        criterion=criterion,
        protect_resting_face=protect_resting_face,
        protect=protect or None,
        stylizer=stylizer,
        guidance=guidance,
        field=field,
    )
    report(run, as_json=as_json)


@app.command("freestyle")
@command
def freestyle_command(
    model: Model,
    prompt: Prompt,
    material: MaterialName = "PLA",
    loads: LoadFile = None,
    minimum_wall: MinimumWall = None,
    iterations: Iterations = None,
    seed: Seed = None,
    amplitude: Amplitude = None,
    orientations: Orientations = None,
    poses: Poses = None,
    criterion: Criterion = None,
    protect: Regions = None,
    stylizer: Stylizer = None,
    guidance: Guidance = None,
    field: StyleField = None,
    vertices: Vertices = 25_000,
    scale: Scale = None,
    more: More = None,
    device: Device = "auto",
    folder: Folder = None,
    as_json: Json = False,
) -> None:
    """Style a part without feedback; one drop test at the end."""
    run = carry_out(
        model,
        prompt,
        material,
        vertices,
        scale,
        device,
        folder,
        freestyle=True,
        as_json=as_json,
        loads=loads,
        minimum_wall=minimum_wall,
        more=more,
        iterations=iterations,
        seed=seed,
        amplitude=amplitude,
        orientations=orientations, poses=poses,
        criterion=criterion,
        protect=protect or None,
        stylizer=stylizer,
        guidance=guidance,
        field=field,
    )
    report(run, as_json=as_json)


@app.command("branch")
@command
def branch_command(
    address: Annotated[str, typer.Argument(metavar="DIR@ITERATION", help="Where to branch: DIR@120 or DIR@lane:120.")],
    lane: Annotated[str, typer.Option(help="Name of the new lane.")] = "",
    prompt: Annotated[str | None, typer.Option("--prompt", "-p", help="Another style.")] = None,
    material: Annotated[str | None, typer.Option("--material", "-m", help="Another material.")] = None,
    loads: LoadFile = None,
    minimum_wall: MinimumWall = None,
    control: Control = None,
    normalisation: Normalisation = None,
    threshold: Threshold = None,
    schedule: Schedule = None,
    every: Every = None,
    iterations: Iterations = None,
    seed: Seed = None,
    amplitude: Amplitude = None,
    orientations: Orientations = None,
    poses: Poses = None,
    criterion: Criterion = None,
    protect_resting_face: Protect = None,
    protect: Regions = None,
    stylizer: Stylizer = None,
    guidance: Guidance = None,
    field: StyleField = None,
    more: More = None,
    device: Device = "auto",
    as_json: Json = False,
) -> None:
    """Go on from a checkpoint with other settings, in a new lane of the same run directory."""
    from mechstyle.loop.store import parse_address  # noqa: PLC0415
    from mechstyle.runs.run import Run  # noqa: PLC0415 — physics is loaded when something is run

    root, origin, iteration = parse_address(address)
    parent = Run.open(f"{root}@{origin}", device)
    run = parent.branch(
        iteration,
        lane=lane,
        **merged(
            more, prompt=prompt, material=material, loads=loads,
            minimum_wall=minimum_wall,
            control=control,
            normalisation=normalisation,
            threshold=threshold,
            schedule=schedule,
            every=every,
            iterations=iterations,
            seed=seed,
            amplitude=amplitude,
            orientations=orientations, poses=poses,
            criterion=criterion,
            protect_resting_face=protect_resting_face,
            protect=protect or None,
            stylizer=stylizer,
            guidance=guidance,
            field=field,
        ),
    )
    with telling(run.recipe.iterations, quiet=as_json) as teller:
        finish(run, teller)
    report(run, as_json=as_json)
