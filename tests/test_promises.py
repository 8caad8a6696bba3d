"""What README, tutorial and the Studio's page promise, asked as a user asks: by public Python, the command line, and the Studio alone.

Nothing in here knows how it is done. Most look at one small run of a box, whose relief is corrected at its end.
"""

from __future__ import annotations

import contextlib
import itertools
import json
import re
import shutil
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from typer.testing import CliRunner

import mechstyle as ms
from mechstyle import teaching
from mechstyle.cli.app import app
from mechstyle_widgets import RunViewer, Studio, StudioState, Timeline
from support import ROOT

BOX = ROOT / "tests" / "cli" / "box.obj"
DROPS = {"height": "20 m", "tolerance": "0.3 mm", "orientations": 2, "nearly_flat": False, "window": 0.4}
ASKED = {**DROPS, "element": "tet4", "iterations": 12, "schedule": "every", "every": 4, "relief": 3.0, "side": "inwards"}
"""Settings of the one run: bricks 3 mm deep in a box that falls 20 m."""
SMALL = 600
PATIENCE = 120.0
"""Seconds before a test gives up; nothing waits this long."""
OUTCOMES = ("HOLDS", "NO WORSE", "FAILS")


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    return tmp_path_factory.mktemp("promises")


@pytest.fixture(scope="module")
def run(folder) -> ms.Run:
    """The run, by Python."""
    return ms.stylize(ms.load(str(BOX)), "brick", vertices=SMALL, out=folder / "box", name="box", **ASKED)


def figures(verdict: ms.Verdict) -> list[tuple[object, ...]]:
    """All that a verdict says of each test."""
    return [
        (verdict.outcome, verdict.words),
        *((row.landing, row.load, row.outcome, row.permanent_set, row.plastic_strain) for row in verdict.rows),
    ]


def command(*words: object, code: int = 0) -> SimpleNamespace:
    """A command line, and the JSON that it prints if it was asked for."""
    done = CliRunner().invoke(app, [str(word) for word in words], env={"COLUMNS": "160", "NO_COLOR": "1"})
    assert done.exit_code == code, done.output
    assert "Traceback" not in done.output
    return SimpleNamespace(said=done.output, json=json.loads(done.stdout) if "--json" in words else None)


def typed(settings: dict[str, object]) -> list[object]:
    """Settings as options of the command line."""
    return [word for name, value in settings.items() for word in ("--set", f"{name}={value}")]


@contextlib.contextmanager
def studio(*part: object, **settings: object):
    """A Studio that is closed in the end; its `go()` presses Run and waits for the end."""
    made = Studio(*part, **settings)

    def go() -> None:
        made.controller.run()
        assert made.state.message == ""
        made.state.session.wait(PATIENCE)
        made.state.pump()
        assert made.state.status == "finished", made.state.message

    made.go = go
    try:
        yield made
    finally:
        made.close()


def words_of(widget: object) -> str:
    """What a widget and those in it say on the page."""
    own = [getattr(widget, name, "") for name in ("value", "description")]
    inner = [words_of(child) for child in getattr(widget, "children", ())]
    return re.sub(r"<style.*?</style>|<[^>]*>", " ", " ".join([*(text for text in own if isinstance(text, str)), *inner]), flags=re.DOTALL)


# --- the verdict ----------------------------------------------------------------------------------------------------


def test_what_holds_with_a_pattern_larger_than_asked_is_not_sure_of_the_same_part_with_more_vertices(run):
    """Coarse bricks held where fine ones cracked: five of thirty parts, each sure of it."""
    noted = [float(found[1]) for note in run.summary.notes if (found := re.search(r"enlarged ([\d.]+)x", note))]
    assert noted
    verdict = run.verdict
    assert verdict.passes
    assert not verdict.sure
    assert f"the pattern is {max(noted):.1f} times larger than asked" in verdict.words
    assert "larger" not in run.summary.plain.words, "the plain part has none"


def test_what_a_finished_run_delivers_carries_its_verdict(run, folder):
    """“The part that was tested”: also a run whose relief was corrected, whichever correction it ends with."""
    assert run.finished
    assert len([entry for entry in run.history if entry.iteration == 12 and entry.verdict]) > 2, "the run is to be a corrected one"
    for suffix in ("3mf", "glb", "ply", "obj", "stl"):
        path = run.export(folder / f"given.{suffix}")
        beside = json.loads(path.with_name(f"{path.name}.json").read_text())
        assert beside["verdict"]["outcome"] == run.verdict.outcome, suffix
        assert [row["permanent_set"] for row in beside["verdict"]["rows"]] == [row.permanent_set for row in run.verdict.rows]
        assert beside["quality"]["thinnest"] > 0.0
    assert figures(run.exported(folder / "part.3mf").verdict) == figures(run.verdict) == figures(run.checkpoint().verdict)


def test_a_surface_that_was_not_tested_says_so_and_has_no_verdict(run, folder):
    given = run.exported(folder / "between.stl", iteration=6)
    assert given.verdict is None
    assert "NOT TESTED since iteration 4" in " ".join(given.warnings)
    assert command("export", f"{run.store.root}@6", "--out", folder / "between.glb", "--json").json["export"]["verdict"] is None


def is_just(verdict: ms.Verdict) -> None:
    """HOLDS is said where nothing that was asked for stays bent beyond the tolerance or cracks, and nowhere else."""
    within = all(
        row.permanent_set <= verdict.tolerance and row.plastic_strain <= row.elongation and not row.collapses for row in verdict.rows
    )
    assert (verdict.outcome == "HOLDS") == within, verdict.words
    assert verdict.passes == (verdict.outcome != "FAILS")


@pytest.fixture(scope="module")
def falls() -> dict[str, ms.lab.PartTest]:
    """The box as it is, from heights that double."""
    part, ways = ms.load(str(BOX)), {**DROPS, "orientations": 4}
    return {height: ms.simulate(part, vertices=SMALL, **{**ways, "height": height}) for height in ("0.5 m", "1 m", "2 m", "4 m")}


@pytest.mark.slow
def test_holds_means_that_no_landing_that_was_asked_for_bends_it_beyond_the_tolerance(run, falls):
    tests = [entry.verdict for entry in run.history if entry.verdict] + [fall.verdict for fall in falls.values()]
    assert {verdict.outcome for verdict in tests} >= {"HOLDS", "FAILS"}
    for verdict in tests[1:]:
        is_just(verdict)
    assert [len(fall.verdict.rows) for fall in falls.values()] == [4] * 4, "what was asked for is dropped and decides"
    assert all(row.decides for fall in falls.values() for row in fall.verdict.rows)


@pytest.mark.slow
def test_from_twice_the_height_no_less_stays_bent_and_the_outcome_is_no_better(falls):
    lower = [fall.verdict for fall in falls.values()]
    for below, above in itertools.pairwise(lower):
        assert OUTCOMES.index(above.outcome) >= OUTCOMES.index(below.outcome)
        for less, more in zip(below.rows, above.rows, strict=True):
            assert more.permanent_set >= less.permanent_set - 1e-9, more.landing


@pytest.mark.slow
def test_a_wider_tolerance_and_a_lower_fall_never_turn_a_part_that_holds_into_one_that_fails(falls):
    strict, wide = (ms.simulate(ms.load(str(BOX)), vertices=SMALL, **{**DROPS, "orientations": 4, "height": "1 m", "tolerance": t})
                    for t in ("0.01 mm", "9 mm"))  # fmt: skip
    assert OUTCOMES.index(wide.verdict.outcome) <= OUTCOMES.index(strict.verdict.outcome)
    assert wide.verdict.outcome != "FAILS" or any(row.cracks for row in wide.verdict.rows)
    assert [row.permanent_set for row in strict.verdict.rows] == [row.permanent_set for row in falls["1 m"].verdict.rows]


# --- what is excluded -----------------------------------------------------------------------------------------------


UNTESTED = {**ASKED, "iterations": 5, "schedule": "never", "guarantee": False, "orientations": 1, "window": 0.1}


def moved(made: ms.Run) -> np.ndarray:
    """How far each vertex was moved by the style [mm]."""
    return np.linalg.norm(made.surface().vertices - made.part.surface.vertices, axis=1)


def test_what_is_protected_and_what_it_stands_on_stay_plain(tmp_path):
    made = ms.stylize(ms.load(str(BOX)), "brick", vertices=SMALL, out=tmp_path / "run", protect="top 4", **UNTESTED)
    held, plain = ms.protect(ms.load(str(BOX)), "top 4", vertices=SMALL), made.part.surface
    np.testing.assert_array_equal(held.surface.vertices, plain.vertices)
    assert held.frozen[plain.vertices[:, 2] >= 6.0].all(), "the uppermost 4 of 20 mm"
    assert held.frozen.sum() > 50
    stands = plain.vertices[:, 2] < -10.0 + 1e-6
    assert moved(made)[held.frozen | stands].max() == 0.0
    assert moved(made).max() > 0.5, "the rest is styled"


@pytest.mark.parametrize(("prompt", "excluded"), [("brick except the top", (0.0, 10.0)), ("only the top: brick", (-10.0, 0.0)),
                                                  ("brick, top smooth 5 mm", (5.0, 10.0))])  # fmt: skip
def test_a_place_that_a_prompt_excludes_stays_plain_but_for_a_triangle_at_its_border(prompt, excluded, tmp_path):
    made = ms.stylize(ms.load(str(BOX)), prompt, vertices=SMALL, out=tmp_path / "run", **UNTESTED)
    low, high = excluded
    z, edge = made.part.surface.vertices[:, 2], 4.0
    inside = (z >= (low + edge if low > -10.0 else low)) & (z <= (high - edge if high < 10.0 else high))
    assert inside.sum() > 50
    assert moved(made)[inside].max() == 0.0
    assert moved(made).max() > 0.1


@pytest.mark.parametrize("prompt", ["handle: leather", "saxophone"])
def test_what_cannot_be_read_is_refused_by_one_sentence_everywhere_and_nothing_is_written(prompt, tmp_path):
    with pytest.raises(ms.BadInput) as caught:
        ms.stylize(ms.load(str(BOX)), prompt, vertices=SMALL, out=tmp_path / "run")
    assert "\n" not in str(caught.value)
    refused = command("run", BOX, "--prompt", prompt, "--vertices", SMALL, "--out", tmp_path / "run", "--json", code=2).json
    assert refused["error"] == str(caught.value)
    assert list(tmp_path.iterdir()) == []


# --- one answer everywhere -----------------------------------------------------------------------------------------


@pytest.mark.slow
def test_python_command_line_and_studio_give_the_same_figures(run, folder):
    printed = command("run", BOX, "--prompt", "brick", "--vertices", SMALL, *typed(ASKED), "--out", folder / "typed", "--json").json
    assert [row["permanent_set"] for row in printed["rows"]] == [row.permanent_set for row in run.verdict.rows]
    assert (printed["outcome"], printed["words"]) == (run.verdict.outcome, run.verdict.words)
    with studio(BOX, prompt="brick", vertices=SMALL, folder=str(folder / "pressed"), **ASKED) as made:
        made.go()
        assert figures(made.run.verdict) == figures(run.verdict)
        np.testing.assert_array_equal(made.run.surface().vertices, run.surface().vertices)
        assert run.verdict.outcome in words_of(made.viewer.badge)
    opened = ms.Run.open(folder / "typed")
    assert [entry.digest for entry in opened.history] == [entry.digest for entry in run.history], "the same bytes in every iteration"


def test_the_trophy_is_the_same_in_lesson_python_and_studio(folder):
    """The demo's settings are the lessons': tests/cli/test_demo.py."""
    quick = {"iterations": 4, "schedule": "never", "guarantee": False, "nearly_flat": False, "window": 0.3, "element": "tet4"}
    lesson = teaching.run("brick", folder=folder / "lesson", **quick)
    trophy = teaching.trophy()
    python = ms.stylize(trophy, "brick", vertices=len(trophy.vertices), out=folder / "python", **{**teaching.STYLE, **quick})
    assert figures(python.verdict) == figures(lesson.verdict)
    with studio(folder=str(folder / "opened"), **quick) as made:
        assert made.wanted().recipe.settings == lesson.recipe.settings
        made.go()
        assert figures(made.run.verdict) == figures(lesson.verdict)


@pytest.mark.slow
def test_a_second_run_equals_the_first_and_the_same_call_only_opens_it(run, folder):
    again = command("rerun", run.store.root, "--out", folder / "again", "--json").json
    assert again["equal"]
    assert [entry.digest for entry in ms.Run.open(folder / "again").history] == [entry.digest for entry in run.history]
    before = {path: path.read_bytes() for path in (run.store.root / "objects").rglob("*") if path.is_file()}
    same = ms.stylize(ms.load(str(BOX)), "brick", vertices=SMALL, out=run.store.root, name="box", **ASKED)
    assert (same.store.root, figures(same.verdict)) == (run.store.root, figures(run.verdict))
    assert {path: path.read_bytes() for path in (run.store.root / "objects").rglob("*") if path.is_file()} == before


def test_other_settings_leave_a_finished_run_as_it_is(run):
    before = [entry.digest for entry in run.history]
    other = command("run", BOX, "--prompt", "stone", "--vertices", SMALL, *typed(ASKED), "--out", run.store.root, "--json", code=2)
    assert "other settings" in other.json["error"]
    assert [entry.digest for entry in ms.Run.open(run.store.root).history] == before


# --- pictures and pages ---------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_a_caption_is_of_the_iteration_that_is_on_show(run):
    """Tested ones by their outcome, the others as not tested since the last test before."""
    tested = {entry.iteration: entry.verdict for entry in run.history if entry.verdict}
    with studio(run) as made:
        for iteration in (12, 8, 6):
            made.state.iteration = iteration
            said, last = words_of(made.viewer.badge), max(one for one in tested if one <= iteration)
            expected = tested[last].outcome if last == iteration else f"since iteration {last}"
            assert expected in said, iteration
            assert ("NOT TESTED" in said) is (last != iteration)
            np.testing.assert_allclose(made.viewer.subject.mesh.vertices, run.surface(iteration).vertices)
            shown = command("show", f"{run.store.root}@{iteration}", "--out", run.store.root.parent / "shown.png", "--json").json
            assert (shown["iteration"], shown["verdict"] is not None) == (iteration, iteration in tested)


def test_over_a_picture_of_a_doubtful_verdict_stands_that_it_is_not_sure(run, monkeypatch):
    titles = []
    monkeypatch.setattr("mechstyle.runs.run.picture", lambda *_, title: titles.append(title))
    run.show()
    assert not run.verdict.sure
    assert titles == [f"{run.record.name}, iteration 12: {run.verdict.short} (not sure)"]


def test_before_a_run_nothing_is_called_tested():
    with studio(BOX, prompt="brick", vertices=SMALL, **ASKED) as made:
        said = words_of(made.viewer.badge)
        assert made.run is None
        assert not re.search("HOLDS|NO WORSE|FAILS", said)
        assert made.run_controls.title == "box, brick"


def test_a_report_is_one_file_that_loads_nothing_and_says_the_verdict(run, folder):
    page = run.report(folder / "report.html").read_text(encoding="utf-8")
    assert not re.search(r"""(?:src|href)=["']?(?:https?:)?//|@import|url\(["']?http""", page)
    assert run.verdict.outcome in page
    assert all(f"{row.permanent_set:.2f} mm" in page for row in run.verdict.rows if row.permanent_set > 0.05)


# --- stopping, reopening, branching ---------------------------------------------------------------------------------


@pytest.mark.slow
def test_stopped_closed_and_opened_again_it_shows_what_was_and_goes_on_to_the_same(run, folder):
    where = folder / "stopped"
    with studio(BOX, prompt="brick", vertices=SMALL, folder=str(where), **ASKED) as made:
        for _ in range(5):
            made.controller.step()
            made.state.session.wait(PATIENCE)
            made.state.pump()
        made.controller.stop()
        made.state.session.wait(PATIENCE)
        made.state.pump()
        root, was = made.run.store.root, made.state.iteration
        assert 0 < was < 12
        seen = made.viewer.subject.mesh.vertices.copy()
    with studio(str(root)) as made:
        assert (made.state.iteration, made.prompt_box.prompt, made.controller.differs()) == (was, "brick", {})
        np.testing.assert_array_equal(made.viewer.subject.mesh.vertices, seen)
        made.go()
        assert [entry.digest for entry in made.run.history] == [entry.digest for entry in run.history]


def test_a_branch_equals_its_parent_up_to_where_it_leaves_it_and_leaves_the_parent_alone(run):
    before = [entry.digest for entry in run.history]
    lane = run.branch(8, lane="careful", threshold=0.5).go()
    mine = [(entry.iteration, entry.digest) for entry in lane.history]
    assert [one for one in mine if one[0] <= 8] == [(entry.iteration, entry.digest) for entry in run.history if entry.iteration <= 8]
    assert lane.recipe.settings["threshold"] == 0.5
    assert {entry.digest for entry in lane.history if entry.iteration > 8}.isdisjoint(before)
    assert [entry.digest for entry in ms.Run.open(run.store.root).history] == before


def test_viewer_and_timeline_stand_alone(run):
    state = StudioState(run)
    viewer, timeline = RunViewer(state), Timeline(state)
    assert run.verdict.outcome in words_of(viewer.badge)
    assert timeline.iteration == 12
    for widget in (viewer, timeline):
        widget.close()


# --- files ----------------------------------------------------------------------------------------------------------


def sorted_rows(points: np.ndarray) -> np.ndarray:
    return points[np.lexsort(np.round(points, 2).T)]


def test_a_3mf_that_is_read_back_is_the_styled_surface_in_millimetres(run, folder):
    styled, back = run.surface(), ms.load(str(run.export(folder / "back.3mf")))
    assert len(back.vertices) == len(styled.vertices)
    assert back.volume == pytest.approx(styled.volume, rel=1e-5)
    low = styled.vertices.min(axis=0) - back.vertices.min(axis=0)  # a slicer's bed begins at 0
    distance = np.abs(back.vertices[:, None] + low - styled.vertices[None]).max(axis=2).min(axis=1)
    assert distance.max() < 1e-3


@pytest.mark.parametrize("suffix", ["stl", "3mf", "obj", "ply", "glb"])
def test_a_part_is_the_same_part_in_every_format(suffix, tmp_path):
    box = ms.load(str(BOX))
    ms.save(box, tmp_path / f"box.{suffix}")
    back = ms.load(str(tmp_path / f"box.{suffix}"))
    assert back.volume == pytest.approx(box.volume, rel=1e-5)
    np.testing.assert_allclose(np.ptp(back.vertices, axis=0), np.ptp(box.vertices, axis=0), rtol=1e-5)


def lost(root: Path) -> None:
    shutil.rmtree(root / "objects")


def cut(root: Path) -> None:
    for path in (path for path in (root / "objects").rglob("*") if path.is_file()):
        path.write_bytes(path.read_bytes()[:-20])


def linked(root: Path) -> None:
    shutil.move(root / "objects", root.parent / "elsewhere")
    (root / "objects").symlink_to(root.parent / "elsewhere")


def other(root: Path) -> None:
    (root / "part.json").write_text('{"name": "../../stolen", "surface": 1}')


@pytest.mark.parametrize("harm", [lost, cut, linked, other], ids=lambda harm: harm.__name__)
def test_a_hostile_or_damaged_run_folder_is_refused_in_a_sentence_everywhere(run, tmp_path, harm):
    root = tmp_path / "run"
    shutil.copytree(run.store.root, root)
    harm(root)
    with pytest.raises(ms.MechStyleError) as caught:
        ms.Run.open(root).surface()
    assert "\n" not in str(caught.value)
    for words in (("show", root), ("export", root, "--out", tmp_path / "stolen.stl"), ("report", root)):
        assert command(*words, code=2).said.startswith("error: ")
    with pytest.raises(ms.MechStyleError):
        Studio(str(root))
    assert not (tmp_path / "stolen.stl").exists()
