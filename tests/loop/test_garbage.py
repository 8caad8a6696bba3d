"""What no lane reaches goes, and nothing else."""

import contextlib
import json
import re
import shlex

import msgspec
import numpy as np
import pytest

from mechstyle._files import exclusive
from mechstyle.cli.finished import gc_command
from mechstyle.errors import BadInput, DamagedStore
from mechstyle.loop.garbage import collect, garbage
from mechstyle.loop.store import Store
from mechstyle.runs.run import Run
from support.hostile import look
from support.kills import contents
from support.lanes import carry_on, lane_on_a_sheet


@pytest.fixture
def run(tmp_path):
    return lane_on_a_sheet(tmp_path / "run", iterations=12)


def littered(run):
    """A run with what kills, lost lanes and forgotten trials leave behind."""
    store = run.store
    branch = run.branch(6, lane="lost", threshold=0.5)
    carry_on(branch)
    (store.root / "lanes" / "lost.json").unlink()
    store.objects.put_array(np.arange(9))
    (store.root / "objects" / "ab").mkdir(exist_ok=True)
    (store.root / "objects" / "ab" / ".new-x").write_bytes(b"half")
    store.memo.remember("1" * 64, {"a": store.objects.put_array(np.arange(11))})
    store.memo.remember(f"delivered-1-0-{'2' * 64}", {"a": 1})


def test_a_run_without_litter_has_none(run):
    assert garbage(run.store).files == ()
    assert garbage(run.store).kept > 0


def test_what_is_left_is_the_run_as_it_was(run):
    before = contents(run.store.root)
    littered(run)
    listed = garbage(run.store)
    assert contents(run.store.root) != before, "listing removes nothing"
    removed = collect(run.store)
    assert removed == listed
    assert len(removed.scraps) == 1
    assert len(removed.memo) == 2
    assert contents(run.store.root) == before
    look(Run(Store(run.store.root)))


def test_a_branch_keeps_the_past_it_shares_and_what_is_remembered_of_it(run):
    store = run.store
    carry_on(run.branch(6, lane="soft", threshold=0.5))
    head, mesh = store.lane("soft").head, store.objects.put_array(np.arange(7))
    delivered = {"displacement": store.objects.put_array(np.arange(5))}
    for key, value in (("mesh-of-x", mesh), (f"delivered-1-0-{head}", delivered), ("3" * 64, 1.25)):
        store.memo.remember(key, value)
    (store.root / "lanes" / "main.json").unlink()
    collect(store)
    assert [entry.iteration for entry in store.history("soft")][:12] == list(range(12))
    assert np.array_equal(store.objects.get_array(mesh), np.arange(7))
    assert store.memo.recall("3" * 64, float) == 1.25
    assert np.array_equal(store.objects.get_array(store.memo.recall(f"delivered-1-0-{head}", dict)["displacement"]), np.arange(5))


def test_while_a_lane_is_carried_on_nothing_is_removed(run):
    littered(run)
    before = contents(run.store.root)
    with exclusive(run.store.root / "locks" / "main.lock", "lane"), pytest.raises(BadInput, match="is being carried on by"):
        collect(run.store)
    assert contents(run.store.root) == before


def test_while_a_branch_is_made_nothing_is_removed(run, monkeypatch):
    """What it needs was removed while no lane named it yet, and nothing could list the run or collect from then on."""
    fork = Store.fork

    def swept(store, *lane):
        with contextlib.suppress(BadInput):
            collect(Store(store.root))
        return fork(store, *lane)

    monkeypatch.setattr(Store, "fork", swept)
    branch = run.branch(6, prompt="", image=np.eye(4, dtype=np.uint8)[..., None])
    assert run.store.objects.path(branch.recipe.style.image).is_file()
    assert garbage(run.store).files == ()


def test_a_branch_is_made_before_or_after_it_is_looked_which_lanes_there_are(run, monkeypatch):
    """One made in between could be carried on, and lose what it has just stored."""
    lanes = Store.lanes

    def looked(store):
        with pytest.raises(BadInput, match="a new branch"), exclusive(store.root / "locks" / ".branches.lock", "a new branch"):
            pass
        return lanes(store)

    monkeypatch.setattr(Store, "lanes", looked)
    collect(run.store)


def test_where_a_record_is_damaged_nothing_is_removed(run):
    littered(run)
    store = run.store
    store.objects.path(store.history()[5].digest).write_bytes(b"rust")
    with pytest.raises(DamagedStore):
        collect(store)
    assert garbage_is_there(store)


def missing_head(store):
    return store.objects.path(store.lane().head)


def missing_array(store):
    return store.objects.path(msgspec.json.decode(store.objects.get(store.lane().head))["displacement"])


def missing_part(store):
    return store.root / "part.json"


def missing_surface(store):
    return store.objects.path(msgspec.json.decode((store.root / "part.json").read_bytes())["surface"])


@pytest.mark.parametrize("lost", [missing_head, missing_array, missing_part, missing_surface])
def test_where_something_a_lane_needs_is_missing_nothing_is_removed(run, lost):
    """A folder that was synced by half lost all that the missing record led to."""
    littered(run)
    file = lost(run.store)
    file.unlink()
    before = contents(run.store.root)
    with pytest.raises(DamagedStore, match=re.escape(str(file)) + " is missing"):
        collect(run.store)
    assert contents(run.store.root) == before
    assert garbage_is_there(run.store)


def test_a_run_with_a_relative_folder_has_the_same_litter(run, monkeypatch):
    littered(run)
    there = garbage(run.store)
    monkeypatch.chdir(run.store.root.parent)
    assert [path.absolute() for path in garbage(Store("run")).files] == list(there.files)


def test_digests_that_name_no_object_are_not_missed(tmp_path):
    """A recipe names its meshes, and a simulation its tetrahedra, by what they hold; a result that is only remembered may be lost."""
    run = lane_on_a_sheet(tmp_path / "run", iterations=12, surface="a" * 64, tetrahedra="b" * 64)
    run.store.memo.remember(f"mesh-of-{'c' * 64}", "d" * 64)
    assert garbage(run.store).files == ()


def test_a_folder_without_a_lane_needs_no_part(run):
    """A run that is stopped while it begins has neither."""
    store = run.store
    (store.root / "lanes" / "main.json").unlink()
    (store.root / "part.json").unlink()
    assert len(garbage(store).objects) == sum(path.is_file() for path in store.objects.root.rglob("*"))


@pytest.mark.parametrize("forged", [b"[" * 100_000, b'{"a": ' + b"9" * 5000 + b"}"], ids=["deep", "a number of 5000 digits"])
def test_a_record_that_nothing_can_read_is_one_sentence(run, forged):
    """A nest of 100 000 brackets, under its own digest, showed a traceback."""
    store = run.store
    store.move("main", msgspec.structs.replace(store.lane(), forked_from=store.objects.put(forged)))
    with pytest.raises(DamagedStore, match="is no record"):
        garbage(store)


def garbage_is_there(store):
    return (store.root / "objects" / "ab" / ".new-x").is_file()


def test_the_command_lists_before_it_removes(run, capsys):
    littered(run)
    gc_command(run.store.root)
    assert f"remove it with: mechstyle gc {run.store.root} --remove" in capsys.readouterr().out.replace("\n", "")
    assert garbage_is_there(run.store)
    spaced = Store(run.store.root.rename(run.store.root.with_name("my run")))
    gc_command(spaced.root)
    told = capsys.readouterr().out.replace("\n", "")
    assert shlex.split(told.partition("remove it with: ")[2]) == ["mechstyle", "gc", str(spaced.root), "--remove"]
    spaced.root.rename(run.store.root)
    gc_command(run.store.root, remove=True, as_json=True)
    told = json.loads(capsys.readouterr().out)
    assert told["removed"]
    assert told["bytes"] > 0
    assert not garbage_is_there(run.store)
    assert msgspec.structs.replace(garbage(run.store), kept=0).files == ()
