"""`run`, `freestyle`, `branch`, `simulate` and what can be done with what they leave."""

from __future__ import annotations

import re
import shutil
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import pytest
import trimesh

from cli.conftest import BOX
from mechstyle.cli.console import out
from mechstyle.cli.run import report
from mechstyle.errors import BadInput
from mechstyle.geometry.filaments import clustered
from mechstyle.loop.engine import Checkpointed
from mechstyle.loop.store import Store
from mechstyle.records import sentences
from mechstyle.records.mesh import TetMesh
from mechstyle.runs.folders import default_folder
from mechstyle.runs.run import Draft, Run
from mechstyle.simulation.part import fitted
from support import ROOT

KEYS = {
    "outcome",
    "doubts",
    "tolerance",
    "rows",
    "words",
    "landings",
    "loads",
    "plain",
    "simulations",
    "style_loss",
    "style_loss_ratio",
    "kept",
    "seconds",
    "files",
}


def contents(root, names=("objects", "lanes")):
    """Files by name; what a killed writer left half-written is not part of a run."""
    files = [path for name in names for path in sorted((root / name).rglob("*")) if path.is_file() and ".new-" not in path.name]
    return {str(path.relative_to(root)): path.read_bytes() for path in files}


def test_run_prints_one_json_object_with_what_the_run_came_to(finished):
    _, _, summary = finished
    assert set(summary) >= KEYS
    assert summary["outcome"] in {"HOLDS", "NO WORSE"}
    flat, other = summary["rows"]
    assert [(row["test"], row["decides"]) for row in summary["rows"]] == [("flat", True), ("any landing", True)]
    for row, landing, plain in zip((flat, other), summary["landings"], summary["plain"]["rows"], strict=True):
        assert row["landing"] == landing["name"] == plain["landing"]
        assert (row["permanent_set"], row["plastic_strain"]) == (landing["permanent_set"], landing["plastic_strain"])
        assert row["plain_permanent_set"] == plain["permanent_set"], "the plain part by itself says the same"
        assert row["permanent_set"] <= row["allowed"]
    assert (summary["tolerance"], summary["loads"]) == (0.2, [])
    assert summary["simulations"][-1]["iteration"] == 12
    assert all(line["reason"] for line in summary["simulations"])
    assert 0 < summary["kept"] < 1.001, "where a style sinks at last, what it reached before may be left"
    assert 0 < summary["style_loss_ratio"] < 1


def test_the_finished_style_is_pictured_before_it_is_tested(finished):
    line, root, _ = finished
    assert (root / "styled.png").read_bytes().startswith(b"\x89PNG")
    (root / "styled.png").unlink()
    again = line.here(*line.styled, "--out", "part")
    assert "not tested yet" in again.stderr
    assert (root / "styled.png").is_file()


def test_json_figures_are_those_of_the_store(finished):
    _, root, summary = finished
    run = Run.open(root, "cpu")
    assert [row.permanent_set for row in run.verdict.rows] == [row["permanent_set"] for row in summary["rows"]]
    assert run.checkpoint().style_loss == summary["style_loss"]


def test_a_part_that_was_thickened_first_is_not_taken_for_the_one_it_was(finished):
    run = Run.open(finished[1])
    for gained, told in ((0.0, False), (1.5, True)):
        run.__dict__["part"] = replace(run.part, mass_gained=gained)  # a cached property
        with out.capture() as said:
            report(run, as_json=False)
        assert ("the plain part is the thickened one, +1.5 g" in said.get()) is told


def test_a_run_ends_with_its_verdict_its_table_and_its_doubt(finished, monkeypatch):
    monkeypatch.setattr(out, "width", 160)
    run = Run.open(finished[1])
    with out.capture() as said:
        report(run, as_json=False)
    verdict, before, text = run.verdict, *said.get().rpartition(run.verdict.head)[::2]
    assert before.splitlines() == [f"3MF: {run.summary.files['model']}"]
    words = " ".join(text.split())
    for row in sentences.tabulated(verdict)[1]:
        assert " ".join(row[:-1]) in words
    assert verdict.doubt in words
    assert f"style kept {run.summary.kept:.0%}" in words


def test_a_run_prints_twelve_lines_after_it_is_done_and_one_share_of_the_style(finished):
    line, _, summary = finished
    done = line.here(*line.styled, "--out", "part")
    assert len(done.stdout.strip().splitlines()) <= 12
    assert done.stdout.count("style kept") == 1
    assert not re.search(r"style loss|morphed|seconds:|purged|vertex \d", done.stdout + done.stderr)
    once = [text for text in summary["notes"] if (done.stdout + done.stderr).count(text) > 1]
    assert once == [], "what was said while it ran is not said again"


@pytest.mark.slow
def test_a_run_of_all_landings_ends_with_its_result_in_twelve_lines_of_a_narrow_terminal(mechstyle, monkeypatch):
    """By default a part lands flat and nearly flat; only what costs time is less than the default here."""
    monkeypatch.setattr(out, "width", 80)
    quick = ("--set", "element=tet4", "--set", "window=0.4")
    command = ("run", str(BOX), "--prompt", "brick", "--vertices", "600", "--iterations", "12", *quick)
    done, run = mechstyle.here(*command, "--out", "part"), Run.open(mechstyle.folder / "part")
    before, head, after = done.stdout.partition(run.verdict.head)
    assert head, "the sentence is there"
    assert before.split() == ["3MF:", run.summary.files["model"]]
    assert len(done.stdout.strip().splitlines()) <= 12
    assert len(run.verdict.rows) > 6
    assert after.count("nearly flat") == 1, "a line for the worst of its kind"


def test_details_have_what_the_result_leaves_out(finished):
    line, _, summary = finished
    whole = line.here(*line.styled, "--out", "part", "--details").stdout
    assert "style loss" in whole
    assert "seconds: " in whole
    assert all(path in whole for path in summary["files"].values())


def test_the_same_command_again_changes_nothing_and_says_the_same(finished):
    line, root, summary = finished
    before = contents(root)
    again = line.here(*line.styled, "--out", "part", "--json").json
    assert contents(root) == before
    assert {key: again[key] for key in KEYS - {"seconds"}} == {key: summary[key] for key in KEYS - {"seconds"}}


def test_freestyle_simulates_once_and_keeps_everything(mechstyle):
    summary = mechstyle.here("freestyle", *mechstyle.styled[1:], "--out", "free", "--json").json
    assert [line["reason"] for line in summary["simulations"]] == ["last iteration"]
    assert summary["kept"] == pytest.approx(1.0, abs=1e-4)


@pytest.fixture
def branched(finished, tmp_path):
    line, root, _ = finished
    copy = tmp_path / "part"
    shutil.copytree(root, copy)
    outcome = line.here("branch", f"{copy}@6", "--lane", "linear", "--control", "linear", "--schedule", "every", "--every", "3", "--json")
    return line, copy, outcome.json


def test_a_branch_shares_its_past_and_follows_its_own_settings(branched):
    _, root, summary = branched
    store = Store(root)
    main, branch = store.history("main"), store.history("linear")
    assert [entry.digest for entry in branch[:7]] == [entry.digest for entry in main[:7]]
    assert branch[7].digest != main[7].digest
    assert [entry["iteration"] for entry in summary["simulations"] if entry["iteration"] > 6][:2] == [9, 12]


def test_the_branch_of_the_readme_puts_a_finished_run_under_a_mask(finished, tmp_path):
    """A branch with a threshold alone did nothing, for a run that finishes first has no masks."""
    line, root, _ = finished
    shutil.copytree(root, tmp_path / "cup")
    (command,) = re.findall(r"`mechstyle (branch .+?)`", (ROOT / "README.md").read_text())
    done = line.here(*command.replace("runs/cup@60", f"{tmp_path / 'cup'}@6").split(), "--details")
    assert "does nothing" not in done.stderr
    lane = line.here("log", tmp_path / "cup", "--json").json["lanes"][-1]
    assert Run.open(f"{tmp_path / 'cup'}@{lane['lane']}").recipe.schedule.when == "stress"
    idle = line.here("branch", f"{tmp_path / 'cup'}@main:6", "--threshold", "0.5").stderr
    assert "threshold does nothing without masks" in idle


def test_log_lists_both_lanes_with_reasons(branched):
    line, root, _ = branched
    lanes = line.here("log", root, "--json").json["lanes"]
    assert [lane["lane"] for lane in lanes] == ["main", "linear"]
    assert lanes[1]["forked_at"] == 6
    text = line.here("log", root).stdout
    assert "branched at 6" in text
    assert "every 3 iterations" in text


def test_log_lists_one_lane_where_one_is_named(branched):
    line, root, _ = branched
    assert [lane["lane"] for lane in line.here("log", f"{root}@main", "--json").json["lanes"]] == ["main"]


def test_a_branch_needs_an_iteration_that_exists(finished):
    line, root, _ = finished
    assert "holds 0 to 12" in line.here("branch", f"{root}@99", "--control", "linear", code=2).stderr


def test_a_run_says_what_its_painted_file_costs_and_an_export_in_ones_own_filaments(finished):
    line, root, told = finished
    assert any(": the 3MF is painted in 2 filaments, #" in note for note in told["notes"])
    mine = clustered(Run.open(root, "cpu").surface().colours, 2)
    shown = line.here("export", root, "--palette", ",".join(mine), "--out", "mine.3mf").stdout
    assert f"1 {mine[0]}" in shown
    assert f"2 {mine[1]}" in shown
    assert "layers" in shown
    assert "fewer changes: " in shown
    refused = line.here("export", root, "--palette", "red", "--out", "mine.3mf", code=2).stderr
    assert "'red' is no colour of a palette" in refused


@pytest.mark.parametrize("form", ["3mf", "glb", "obj", "ply", "stl"])
def test_export_writes_every_format(finished, tmp_path, form):
    line, root, _ = finished
    line.here("export", f"{root}@5", "--format", form, "--out", tmp_path / f"part.{form}")
    mesh = trimesh.load(tmp_path / f"part.{form}", force="mesh")
    assert mesh.is_watertight
    scale = 1000.0 if form == "glb" else 1.0  # glTF is in metres
    assert mesh.volume * scale**3 == pytest.approx(Run.open(root, "cpu").surface(5).volume, rel=1e-3)


def test_export_takes_the_format_from_the_file_and_refuses_a_contradiction(finished, tmp_path):
    line, root, _ = finished
    line.here("export", root, "--out", tmp_path / "part.stl")
    assert (tmp_path / "part.stl").read_bytes()[:2] != b"PK", "it is no 3MF"
    refused = line.here("export", root, "--format", "stl", "--out", tmp_path / "x.3mf", code=2).stderr
    assert f"--format stl contradicts --out {tmp_path}/x.3mf" in refused
    assert "call the file x.stl" in refused
    assert not (tmp_path / "x.3mf").exists()


def test_show_writes_a_picture(finished, tmp_path):
    line, root, _ = finished
    outcome = line.here("show", f"{root}@6", "--out", tmp_path / "six.png", "--json").json
    assert outcome["iteration"] == 6
    assert (tmp_path / "six.png").read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"


def test_simulate_reports_the_part_as_it_is(mechstyle):
    small = ("simulate", BOX, "--vertices", "600", "--window", "0.4")
    outcome = mechstyle.here(*small, "--vtu", "--json").json
    assert outcome["outcome"] == "HOLDS"
    flat, *nearly = outcome["rows"]
    assert (flat["test"], flat["decides"], flat["plain_permanent_set"]) == ("flat", True, None)
    assert flat["permanent_set"] <= flat["allowed"] == outcome["tolerance"] == 0.2
    assert {(row["test"], row["decides"]) for row in nearly} == {("nearly flat", True)}
    assert outcome["words"].startswith("HOLDS a fall of 1.5 m: ")
    assert set(outcome["files"]) == {"picture", "history", "vtu"}
    for file in outcome["files"].values():
        assert (mechstyle.folder / file).is_file()
    assert [landing["way"] for landing in outcome["landings"]] == ["flat", *["nearly flat"] * (len(outcome["landings"]) - 1)]
    assert [row["landing"] for row in outcome["rows"]] == [landing["name"] for landing in outcome["landings"]]
    assert len(outcome["history"]["time"]) == len(outcome["history"]["contact_force"]) > 100


def test_simulate_says_its_files_the_verdict_and_the_table_and_the_rest_where_it_is_asked_for(mechstyle):
    small = ("simulate", BOX, "--vertices", "600", "--no-nearly-flat", "--window", "0.3")
    _picture, _history, first, *rest = (" ".join(line.split()) for line in mechstyle.here(*small).stdout.splitlines() if line)
    assert first.startswith("HOLDS a fall of 1.5 m: ")
    (flat,) = (line for line in rest if line.startswith("flat"))
    assert rest[rest.index(flat) - 1].endswith("allowed strain outcome")
    assert re.fullmatch(r"flat [\d.]+ mm 0\.20 mm [\d.]+% HOLDS( \(not sure\))?", flat)
    assert "the floor took" not in " ".join(rest)
    assert "the floor took" in mechstyle.here(*small, "--details").stdout
    assert any("--original FILE compares it with its plain part" in line for line in rest)


def test_simulate_judges_beside_an_original_that_is_named(mechstyle):
    small = ("simulate", BOX, "--vertices", "600", "--no-nearly-flat", "--window", "0.2")
    beside = (*small, "--original", BOX)
    outcome, said = mechstyle.here(*beside, "--json").json, " ".join(mechstyle.here(*beside).stdout.split())
    flat = outcome["rows"][0]
    assert outcome["original"]["landings"][0]["permanent_set"] == flat["plain_permanent_set"] == flat["permanent_set"]
    assert outcome["fit"]["most"] > outcome["fit"]["mean"] > 0.0
    assert "test plain styled allowed strain outcome" in said
    assert "over the original, the mesh follows" in said
    assert "--original FILE" not in said


def test_simulate_after_a_standard_names_landings_and_claims_nothing(mechstyle):
    flat = ("--orientations", "2", "--no-nearly-flat", "--window", "0.1")
    small = ("simulate", BOX, "--vertices", "600", "--standard", "ista-1a", *flat)
    said = " ".join(mechstyle.here(*small).stdout.split())
    assert "simulated orientations after ISTA 1A, drop test below 10 kg, but 2 orientations instead of 11" in said
    assert "corner 2-3-5 " in said
    assert "without a package" in said
    assert "pass" not in said.lower()
    outcome = mechstyle.here(*small, "--json").json
    assert [landing["name"] for landing in outcome["landings"]][1:] == ["corner 2-3-5"]
    assert outcome["after_standard"].startswith("simulated orientations after ISTA 1A")


def test_materials_are_listed_with_their_spread_and_their_layers(mechstyle):
    said = " ".join(mechstyle.here("materials").stdout.split())
    assert "23 to 65 MPa" in said
    assert "generic" in said
    known = mechstyle.here("materials", "--json").json
    assert {material["name"]: material["layer_ratio"] for material in known["materials"]}["ABS"] is None
    assert set(known["spread"]) == {material["name"] for material in known["materials"]}


def test_simulate_carries_the_loads_of_a_file_and_warns_of_thin_walls(mechstyle):
    supports, loads = "[{ at = 'resting face' }]", "[{ at = { near = [18, 0, 10, 6] }, force = [0, 0, -50] }]"
    case = f"[[case]]\nname = 'hand'\nsupports = {supports}\nloads = {loads}\n"
    (mechstyle.folder / "loads.toml").write_text(case, encoding="utf-8")
    small = ("simulate", BOX, "--vertices", "600", "--orientations", "1", "--no-nearly-flat", "--window", "0.3")
    outcome = mechstyle.here(*small, "--load", "loads.toml", "--minimum-wall", "25", "--json").json
    (hand,) = outcome["loads"]
    row = next(row for row in outcome["rows"] if row["test"] == "load")
    assert (hand["name"], row["load"], row["landing"]) == ("hand", "hand", "")
    assert (row["permanent_set"], row["carries"]) == (hand["permanent_set"], hand["factor"])
    assert hand["deflection"] > 0.0
    assert "thinner than the 25 mm minimum" in outcome["warning"]


def test_simulate_judges_by_the_published_rule_where_it_is_asked_to(mechstyle):
    small = ("simulate", BOX, "--vertices", "600", "--no-nearly-flat", "--window", "0.3")
    outcome = mechstyle.here(*small, "--criterion", "paper", "--json").json
    assert [row["test"] for row in outcome["rows"] if row["decides"]] == ["published rule"]
    assert "by the published rule: the largest element stress is " in outcome["words"]


@pytest.mark.parametrize(
    ("control", "schedule"),
    [("linear", "every"), ("exponential", "quadratic"), ("frozen", "exponential"), ("linear", "geometry"), ("exponential", "stress"),
     ("frozen", "never")],
)  # fmt: skip
def test_every_control_and_every_schedule_passes(finished, tmp_path, control, schedule):
    """In one process, on the part of the finished run; neither knows of the other, so that they need not meet in every pair."""
    _, root, _ = finished
    copy = tmp_path / "part"
    shutil.copytree(root, copy)
    branch = Run.open(copy, "cpu").branch(0, control=control, schedule=schedule, every=4, iterations=8, orientations=1)
    assert branch.go().verdict.passes
    reasons = [line.reason for line in branch.summary.simulations]
    assert reasons[-1] == "last iteration" or reasons[-1].startswith("correction")


def test_a_branch_that_goes_nowhere_is_refused_and_leaves_no_lane(finished):
    line, root, _ = finished
    assert "must go beyond it" in line.here("branch", root, "--material", "ABS", code=2).stderr
    assert Store(root).lanes() == ("main",)


def test_an_address_with_an_iteration_does_not_open_the_last_one_silently(finished):
    _, root, _ = finished
    with pytest.raises(BadInput, match="names an iteration"):
        Run.open(f"{root}@5", "cpu")


@pytest.fixture
def part(finished, tmp_path):
    """A copy of the finished run's directory with an @ in its name."""
    copy = tmp_path / "part@home"
    shutil.copytree(finished[1], copy)
    return copy


@pytest.mark.parametrize("lane", ["", "mine"])
def test_an_interrupted_branch_is_carried_on_by_asking_again(part, lane):
    def ask():
        return Run.open(part, "cpu").branch(6, lane=lane, control="linear", orientations=1)

    first = ask()
    next(event for event in first.events() if isinstance(event, Checkpointed) and event.checkpoint.iteration == 8)
    again = ask()
    assert again.lane == first.lane
    assert again.history[-1].iteration == 8
    assert again.go().finished
    assert ask().go().history[-1].digest == again.history[-1].digest
    assert Store(part).lanes() == ("main", first.lane)


def test_other_settings_or_another_fork_are_another_branch(part):
    run = Run.open(part, "cpu")
    lanes = [run.branch(6, control="linear").lane, run.branch(6, control="frozen").lane, run.branch(5, control="linear").lane]
    assert lanes == ["branch-1", "branch-2", "branch-3"]
    with pytest.raises(BadInput, match=r"'branch-1' of .* has other settings or another fork"):
        run.branch(5, lane="branch-1", control="linear")


def test_branches_asked_for_at_the_same_moment_have_names_of_their_own(part, monkeypatch):
    run, together, lanes_of = Run.open(part, "cpu"), threading.Barrier(6), Store.lanes

    def slowly(store):
        """Leave the others time to take the name that is free by this."""
        names = lanes_of(store)
        time.sleep(0.02)
        return names

    def ask(seed):
        together.wait()
        return run.branch(6, seed=seed).lane

    monkeypatch.setattr(Store, "lanes", slowly)

    with ThreadPoolExecutor(6) as pool:
        lanes = list(pool.map(ask, range(1, 7)))
    assert sorted(lanes) == [f"branch-{number}" for number in range(1, 7)]


def test_a_part_meshed_anew_finds_its_run_again(part):
    run = Run.open(part, "cpu")
    anew = replace(run.part, tets=TetMesh(run.part.tets.vertices, run.part.tets.tets[::-1]))
    recipe = fitted(run.recipe, anew)
    assert recipe != run.recipe
    assert default_folder(recipe) == default_folder(run.recipe)
    assert Draft(recipe, anew, folder=part, device="cpu").begin().recipe == run.recipe
    moved = replace(anew, surface=anew.surface.moved(2 * anew.surface.vertices))
    with pytest.raises(BadInput, match="a run of another part: choose another --out"):
        Draft(fitted(recipe, moved), moved, folder=part, device="cpu", beside=False).begin()


def test_a_lane_is_carried_on_by_one_at_a_time(part):
    run = Run.open(part, "cpu")
    events = run.branch(6, control="linear").events()
    next(events)
    with pytest.raises(BadInput, match=r"lane 'branch-1' of .* is being carried on by process"):
        run.branch(6, control="linear").go()
    run.branch(6, control="frozen", iterations=7, orientations=1).go()
    events.close()
    assert next(run.branch(6, control="linear").events())


def test_a_listener_that_raises_leaves_the_lane_free(part):
    run = Run.open(part, "cpu").branch(6, control="linear")

    def broken(_event):
        raise ValueError("broken plot")

    with pytest.raises(ValueError, match="broken plot") as kept:
        run.go(broken)
    assert next(run.events()), kept
