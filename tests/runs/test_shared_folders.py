"""Run folders that somebody else made: nothing in them leads out of them, breaks a command with a traceback, or is believed elsewhere."""

import contextlib
import json
import shlex
import shutil

import msgspec
import numpy as np
import pytest

from mechstyle.cli.finished import gc_command, report_command
from mechstyle.cli.inspect_run import export_command, log_command, show_command
from mechstyle.errors import BadInput, DamagedStore, MechStyleError
from mechstyle.geometry.print_quality import Quality
from mechstyle.loop.store import Store
from mechstyle.runs import export
from mechstyle.runs.orient import ways_up
from mechstyle.runs.report.reproduce import command_for
from mechstyle.runs.rerun import rerun
from mechstyle.runs.run import Run
from support.lanes import lane_on_a_sheet

ELSEWHERE = ("../../outside/stolen", "{outside}/stolen" + "\n" + "x" * 400)
QUALITY = Quality(**dict.fromkeys(Quality.__struct_fields__, 1))


@pytest.fixture
def outside(tmp_path):
    (tmp_path / "outside").mkdir()
    return tmp_path / "outside"


@pytest.fixture(params=ELSEWHERE)
def forged(request, tmp_path, outside):
    """A run whose part is called by the way to another folder."""
    return lane_on_a_sheet(tmp_path / "shared" / "run", iterations=2, name=request.param.format(outside=outside))


@pytest.mark.parametrize(
    "look",
    [
        lambda root: show_command(root, None, as_json=True),
        lambda root: export_command(root, None, None, as_json=True),
        lambda root: report_command(root, None, as_json=True),
    ],
    ids=["show", "export", "report"],
)
def test_a_part_named_by_a_path_is_written_into_its_run_folder(forged, outside, look, capsys, monkeypatch):
    root = forged.store.root
    monkeypatch.setattr(export, "quality", lambda *_: QUALITY)  # a sheet has no volume
    before = set(root.iterdir())
    look(str(root))
    written = json.loads(capsys.readouterr().out)["files"]
    assert {root / name for name in written.values()} == set(root.iterdir()) - before
    assert not list(outside.iterdir())
    assert {path.name for path in root.parent.iterdir()} == {"run"}


def test_the_command_that_makes_a_run_again_writes_into_one_folder(forged):
    folder = shlex.split(command_for(forged, forged.history))[-1]
    assert folder.startswith("again-")
    assert not {"/", "\\", "\n"} & set(folder)


@pytest.mark.parametrize("name", ["objects", "lanes", "memo", "locks", "summaries"])
def test_a_folder_of_a_run_that_is_a_link_is_not_followed(tmp_path, outside, name):
    """With `memo` as a link to somebody's documents `mechstyle gc DIR --remove` removed them: no lane reaches a thesis."""
    root = lane_on_a_sheet(tmp_path / "run", iterations=2).store.root
    (outside / "thesis.txt").write_text("years of work")
    with contextlib.suppress(FileNotFoundError):
        shutil.rmtree(root / name)
    (root / name).symlink_to(outside)
    for look in (lambda: gc_command(root, remove=True), lambda: show_command(str(root), None), lambda: log_command(str(root))):
        with pytest.raises(SystemExit):
            look()
    with pytest.raises(DamagedStore, match=f"{name} is a link"):
        Store(root)
    assert [(path.name, path.read_text()) for path in outside.iterdir()] == [("thesis.txt", "years of work")]


def test_a_run_folder_may_itself_be_reached_by_a_link(tmp_path):
    run = lane_on_a_sheet(tmp_path / "run", iterations=2)
    (tmp_path / "link").symlink_to(run.store.root)
    assert Store.open(tmp_path / "link").lanes() == ("main",)


def test_a_lane_file_by_another_name_than_a_lane_can_have_is_no_lane(tmp_path):
    run = lane_on_a_sheet(tmp_path / "run", iterations=2)
    lanes = run.store.root / "lanes"
    for name in ("a\\b", "a:b", "..", " ", "7", "a\nb"):
        (lanes / f"{name}.json").write_bytes((lanes / "main.json").read_bytes())
    assert run.store.lanes() == ("main",)


# --- damage -------------------------------------------------------------------------------------------------------

DAMAGE = {
    "cut off": lambda data: data[: len(data) // 2],
    "empty": lambda _: b"",
    "another record": lambda _: b'{"name": 7}',
    "not UTF-8": lambda _: b'{"name": "\xff\xfe"}',
    "too deep": lambda _: b"[" * 100_000,
    "a number of 5000 digits": lambda _: b'{"name": ' + b"9" * 5000 + b"}",
    "a list": lambda _: b"[]",
}


@pytest.mark.parametrize("damage", DAMAGE.values(), ids=DAMAGE)
@pytest.mark.parametrize(
    ("file", "read"),
    [
        ("part.json", lambda run: run.record),
        ("summaries/main.json", lambda run: run.summary),
        ("lanes/main.json", lambda run: run.recipe),
    ],
)
def test_a_damaged_record_is_named_in_one_sentence(tmp_path, file, read, damage):
    run = lane_on_a_sheet(tmp_path / "run", iterations=2)
    path = run.store.root / file
    path.write_bytes(damage(path.read_bytes()))
    with pytest.raises(DamagedStore, match=path.name):
        read(run)


def test_a_part_that_encloses_nothing_is_not_dropped_turned_or_measured(tmp_path):
    """`mechstyle rerun`, `orient` and `export` of a folder with a flat sheet in it showed a traceback."""
    run = lane_on_a_sheet(tmp_path / "run")
    for asked in (lambda: rerun(run, tmp_path / "again"), lambda: ways_up(run), run.branch(10, threshold=0.5).go):
        with pytest.raises(DamagedStore, match=r"part\.json.* encloses nothing"):
            asked()
    with pytest.raises(BadInput, match="encloses nothing"):
        run.export(tmp_path / "sheet.stl")
    assert not (tmp_path / "again").exists()


def test_a_run_without_a_record_of_its_part_is_damaged(tmp_path):
    run = lane_on_a_sheet(tmp_path / "run", iterations=2)
    (run.store.root / "part.json").unlink()
    with pytest.raises(DamagedStore, match=r"part\.json"):
        _ = run.record


def _look(run):
    """Everything `log`, `show` and `report` read."""
    _ = run.record, run.part, run.history, run.recipe, run.verdict, run.summary
    _ = run.surface(), run.simulation(), run.checkpoint(0)
    run.report(run.store.root / "page.html")


FORGERIES = {
    "a lane with a head that is a path": ("lanes/main.json", {"head": "../../../etc/passwd"}),
    "a lane with a head that is no digest": ("lanes/main.json", {"head": "\0"}),
    "a lane at a record of another kind": ("lanes/main.json", {"head": "recipe"}),
    "a part without faces": ("part.json", {"surface": "nothing"}),
    "a part of a bare array": ("part.json", {"surface": "thickness"}),
    "tetrahedra of another part": ("part.json", {"tets": "words"}),
    "walls of another part": ("part.json", {"thickness": "words"}),
    "walls without numbers": ("part.json", {"thickness": "surface"}),
}


@pytest.mark.parametrize(("file", "changes"), FORGERIES.values(), ids=FORGERIES)
def test_a_record_that_points_at_the_wrong_thing_is_one_sentence(tmp_path, file, changes):
    run = lane_on_a_sheet(tmp_path / "run", iterations=2)
    path, objects = run.store.root / file, run.store.objects
    record = msgspec.json.decode(path.read_bytes())
    known = {**record, "nothing": objects.put_record({}), "words": objects.put_record({"vertices": "a", "cells": "b"})}
    path.write_bytes(msgspec.json.encode({**record, **{name: known.get(value, value) for name, value in changes.items()}}))
    with pytest.raises(MechStyleError):
        _look(run)


def test_objects_forged_under_their_own_digests_are_one_sentence(tmp_path):
    """Whoever changes an object can change its name as well: what a digest cannot find, reading must."""
    run = lane_on_a_sheet(tmp_path / "run", iterations=2)
    objects, lane = run.store.objects, run.store.lane()
    head = msgspec.json.decode(objects.get(lane.head))
    short, text = objects.put_array(np.zeros(3, np.float32)), objects.put_array(np.array(["a"] * 64))
    for name, value in {"displacement": short, "mask": text, "stress": lane.head, "colour": short, "simulation": lane.recipe}.items():
        run.store.move("main", msgspec.structs.replace(lane, head=objects.put(msgspec.json.encode({**head, name: value}))))
        with pytest.raises(MechStyleError):
            _look(run)


def test_any_byte_of_a_run_may_be_lost(tmp_path):
    run = lane_on_a_sheet(tmp_path / "run", iterations=2)
    random = np.random.default_rng(0)
    files = [path for path in sorted(run.store.root.rglob("*")) if path.is_file() and path.stat().st_size]
    for path in files:
        whole = path.read_bytes()
        for place in random.integers(len(whole), size=3):
            path.write_bytes(whole[:place] + bytes([whole[place] ^ 1 << int(random.integers(8))]) + whole[place + 1 :])
            with contextlib.suppress(MechStyleError):
                _ = run.record, run.part, run.history, run.summary, run.simulation(), run.surface()
        path.write_bytes(whole)
    assert Run(Store(run.store.root)).finished
