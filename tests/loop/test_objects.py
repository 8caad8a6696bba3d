"""Objects and memo: what is put in comes out bit for bit, damage is noticed and named, a full disk loses nothing."""

import dataclasses
import errno
import io
import os
import subprocess
import sys
import zlib
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from mechstyle._files import write_whole
from mechstyle.errors import DamagedStore, MechStyleError
from mechstyle.loop.objects import Objects
from mechstyle.loop.store import Lane, Store
from mechstyle.records import Checkpoint, Doubt, Simulation
from mechstyle.records.mesh import SurfaceMesh, TetMesh
from support.records import AWKWARD, COUNT, VERDICT, checkpoint, landing, recipe, simulation, verdict

KEY = "5" * 64


@pytest.fixture
def store(tmp_path):
    return Store(tmp_path / "run")


def assert_same(one, other):
    """Field by field: arrays in type, shape and bytes, the rest equal."""
    assert type(one) is type(other)
    for field in dataclasses.fields(one):
        left, right = getattr(one, field.name), getattr(other, field.name)
        if isinstance(left, np.ndarray):
            assert_same_array(left, right)
        else:
            assert left == right, field.name


def assert_same_array(one, other):
    assert (one.dtype, one.shape) == (other.dtype, other.shape)
    assert one.tobytes() == other.tobytes()


def files_below(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


# --- round trips --------------------------------------------------------------------------------------------------


SIMULATED = {"verdict": VERDICT, "reason": "vertex 3 moved", "final": True, "simulated_at": 3}


@pytest.mark.parametrize("changes", [{}, SIMULATED], ids=["between", "simulated"])
def test_checkpoint_comes_back_bit_for_bit(store, changes):
    one = checkpoint(**changes)
    assert_same(store.checkpoint(store.objects.put_record(one)), one)


def test_checkpoint_comes_back_with_its_keyframe(store):
    keyframe = {"displacement": AWKWARD, "momentum": np.ones((2, 3), np.float32), "generator": np.array([2**63 + 1], np.uint64)}
    back = store.checkpoint(store.objects.put_record(checkpoint(keyframe=keyframe))).keyframe
    assert list(back) == sorted(keyframe)
    for name, array in keyframe.items():
        assert_same_array(back[name], array)


def test_fields_of_a_checkpoint_read_back_are_frozen(store):
    back = store.checkpoint(store.objects.put_record(checkpoint()))
    with pytest.raises(ValueError, match="read-only"):
        back.mask[0] = 1.0


NOT_FINITE = landing(permanent_set=np.nan, plastic_strain=np.inf, maximum=-np.inf, where=(np.nan, 0.0, 0.0))


def test_numbers_that_are_none_come_back(store):
    """JSON has no word for them; a run that met one must still be readable, if only to say UNKNOWN."""
    one = simulation(landings=(NOT_FINITE,), landing_stress=(), landing_strain=(), landing_set=())
    back = store.objects.get_record(store.objects.put_record(one), Simulation)
    assert repr(back.flat) == repr(NOT_FINITE)
    doubted = verdict(doubts=(Doubt(about="relief", value=np.nan),))
    assert np.isnan(store.checkpoint(store.objects.put_record(checkpoint(verdict=doubted))).verdict.doubts[0].value)
    assert np.isnan(store.checkpoint(store.objects.put_record(checkpoint(style_loss=np.nan))).style_loss)


def test_words_that_look_like_numbers_stay_words(store):
    one = simulation(failure="nan", meshing="12")
    assert_same(store.objects.get_record(store.objects.put_record(one), Simulation), one)


@pytest.mark.parametrize(
    "changes",
    [{}, {"failure": ""}, {"landings": (), "loads": (), "landing_stress": (), "landing_strain": (), "landing_set": (), "load_stress": ()}],
    ids=["failed", "tested", "nothing"],
)
def test_simulation_comes_back_bit_for_bit(store, changes):
    one = simulation(**changes)
    assert_same(store.objects.get_record(store.objects.put_record(one), Simulation), one)


def test_recipe_comes_back_under_its_own_digest(store):
    one = recipe(amplitude=0.1 + 0.2, prompt="petit galet é 石", seed=2**32 - 1)
    assert store.put_recipe(one) == one.digest
    assert store.recipe(one.digest) == one


def test_surface_comes_back_without_its_colours(store, cube):
    back = store.objects.get_mesh(store.objects.put_mesh(cube.coloured(np.ones((8, 3)))), SurfaceMesh)
    assert isinstance(back, SurfaceMesh)
    assert back.digest == cube.digest
    assert back.colours is None


def test_tetrahedra_come_back(store):
    one = TetMesh(np.vstack([np.zeros(3), np.eye(3) / 3]), [[0, 1, 2, 3]])
    back = store.objects.get_mesh(store.objects.put_mesh(one), TetMesh)
    assert isinstance(back, TetMesh)
    assert back.digest == one.digest


@given(array=arrays(st.sampled_from([np.float32, np.float64, np.int32, np.uint8, np.bool_]), array_shapes(max_dims=3, min_side=0)))
def test_any_array_comes_back_in_type_shape_and_bytes(tmp_path_factory, array):
    objects = Objects(tmp_path_factory.getbasetemp() / "arrays")
    assert_same_array(objects.get_array(objects.put_array(array)), array)


def test_a_view_is_stored_as_what_it_shows(store):
    table = np.arange(12, dtype=np.float32).reshape(3, 4)
    assert_same_array(store.objects.get_array(store.objects.put_array(table.T[::2])), np.ascontiguousarray(table.T[::2]))


def test_what_is_neither_record_nor_array_is_refused(store):
    with pytest.raises(TypeError, match="cannot store a complex"):
        store.objects.put_record({"value": 1j})
    with pytest.raises(ValueError, match="Object arrays"):
        store.objects.put_array(np.array([{}], object))


# --- named by content ---------------------------------------------------------------------------------------------


def test_an_object_lies_under_the_digest_of_its_content(store):
    digest = store.objects.put(b"content")
    assert digest == "ed7002b439e9ac845f22357d822bac1444730fbdb6016d3ec9432297b9ec9f73"  # sha256 of the seven letters
    path = store.root / "objects" / digest[:2] / digest[2:]
    assert zlib.decompress(path.read_bytes()) == b"content"


def test_equal_arrays_are_stored_once(store):
    """mask, share, anchor, stress and demand are equal here: one object for the five, displacement, colour and the record."""
    store.objects.put_record(checkpoint())
    assert len(files_below(store.root)) == 4
    store.objects.put_record(checkpoint(iteration=4, mask=np.zeros(COUNT)))
    assert len(files_below(store.root)) == 6


def test_arrays_that_differ_in_type_only_are_two(store):
    assert store.objects.put_array(np.zeros(4, np.float32)) != store.objects.put_array(np.zeros(4, np.int32))


def test_the_same_state_and_past_have_the_same_digest(store, tmp_path):
    elsewhere = Store(tmp_path / "elsewhere")
    assert store.objects.put_record(checkpoint(verdict=VERDICT)) == elsewhere.objects.put_record(checkpoint(verdict=VERDICT))
    assert files_below(store.root) == files_below(elsewhere.root)


def test_the_digest_does_not_depend_on_the_order_a_keyframe_was_filled_in(store):
    a, b = np.zeros(3, np.float32), np.ones(3, np.float32)
    forth, back = checkpoint(keyframe={"a": a, "b": b}), checkpoint(keyframe={"b": b, "a": a})
    assert store.objects.put_record(forth) == store.objects.put_record(back)


@pytest.mark.parametrize(
    "changes",
    [{"iteration": 4}, {"parent": KEY}, {"recipe": KEY}, {"mask": np.zeros(COUNT)}, {"style_loss": 0.3}, {"verdict": VERDICT}],
    ids=lambda changes: next(iter(changes)),
)
def test_another_state_or_past_has_another_digest(store, changes):
    assert store.objects.put_record(checkpoint(**changes)) != store.objects.put_record(checkpoint())


def test_what_is_stored_is_not_written_again(store, monkeypatch):
    store.objects.put_record(checkpoint())
    monkeypatch.setattr("mechstyle.loop.objects.write_whole", lambda path, _: pytest.fail(f"{path} was written again"))
    store.objects.put_record(checkpoint())


def test_many_writers_of_the_same_object_agree(store):
    with ThreadPoolExecutor(8) as pool:
        digests = set(pool.map(lambda _: store.objects.put_record(checkpoint()), range(40)))
    assert len(digests) == 1
    assert_same(store.checkpoint(digests.pop()), checkpoint())
    assert len(files_below(store.root)) == 4


# --- damage -------------------------------------------------------------------------------------------------------


def flip(path):
    """One bit of the content, well compressed again: only the digest can notice."""
    content = bytearray(zlib.decompress(path.read_bytes()))
    content[-1] ^= 1
    path.write_bytes(zlib.compress(content))


DAMAGES = {
    "missing": Path.unlink,
    "empty": lambda path: path.write_bytes(b""),
    "truncated": lambda path: path.write_bytes(path.read_bytes()[:-5]),
    "overwritten": lambda path: path.write_bytes(b"something else"),
    "one bit": flip,
}
damaged = pytest.mark.parametrize("damage", DAMAGES.values(), ids=DAMAGES.keys())


@damaged
def test_a_damaged_record_is_named_by_its_file(store, damage):
    digest = store.objects.put_record(checkpoint())
    path = store.objects.path(digest)
    damage(path)
    with pytest.raises(DamagedStore) as caught:
        store.checkpoint(digest)
    assert str(path) in str(caught.value)
    assert "restore it from a copy" in str(caught.value)
    assert "\n" not in str(caught.value)


@damaged
def test_a_damaged_array_of_a_sound_record_is_named_by_its_file(store, damage):
    digest = store.objects.put_record(checkpoint())
    path = store.objects.path(store.objects.put_array(AWKWARD))
    damage(path)
    with pytest.raises(DamagedStore) as caught:
        store.checkpoint(digest)
    assert str(path) in str(caught.value)


def test_a_log_is_read_although_an_array_is_damaged(store):
    store.move("main", Lane(recipe=KEY, head=store.objects.put_record(checkpoint())))
    store.objects.path(store.objects.put_array(AWKWARD)).unlink()
    assert [entry.iteration for entry in store.history()] == [3]


def test_an_object_of_another_kind_is_damage_too(store):
    digest = store.put_recipe(recipe())
    with pytest.raises(DamagedStore, match="is not a Checkpoint"):
        store.objects.get_record(digest, Checkpoint)


@damaged
def test_storing_the_same_content_again_mends_a_damaged_object(store, damage):
    """Or a run carried on after a power cut would name an object again that it cannot read."""
    digest = store.objects.put_record(checkpoint())
    damage(store.objects.path(digest))
    assert store.objects.put_record(checkpoint()) == digest
    assert_same(store.checkpoint(digest), checkpoint())


def test_a_damaged_lane_is_named_by_its_file(store):
    store.move("main", Lane(recipe=KEY))
    path = store.root / "lanes" / "main.json"
    path.write_bytes(path.read_bytes()[:-3])
    with pytest.raises(DamagedStore) as caught:
        store.lane()
    assert str(path) in str(caught.value)


# --- a disk that refuses ------------------------------------------------------------------------------------------


def refuse(number):
    def refusal(*_, **__):
        raise OSError(number, os.strerror(number))

    return refusal


class FullFile(io.BytesIO):
    write = refuse(errno.ENOSPC)


def opening(made):
    """`Path.open`, except where a file is made."""
    usual = Path.open
    return lambda path, mode="r", **options: made() if mode == "xb" else usual(path, mode, **options)


FULL = {
    "folder": ("pathlib.Path.mkdir", refuse(errno.ENOSPC)),
    "name": ("pathlib.Path.open", opening(refuse(errno.ENOSPC))),
    "content": ("pathlib.Path.open", opening(FullFile)),
    "rename": ("pathlib.Path.replace", refuse(errno.ENOSPC)),
}


@pytest.mark.parametrize(("what", "refusal"), FULL.values(), ids=FULL.keys())
def test_a_full_disk_gets_one_sentence_and_loses_nothing(store, monkeypatch, what, refusal):
    head = store.objects.put_record(checkpoint())
    store.move("main", Lane(recipe=KEY, head=head))
    before = files_below(store.root)
    with monkeypatch.context() as full:
        full.setattr(what, refusal)
        with pytest.raises(MechStyleError) as caught:
            store.objects.put_record(checkpoint(iteration=4))
        with pytest.raises(MechStyleError):
            store.move("main", Lane(recipe=KEY, head="other"))
    message = str(caught.value)
    assert message.startswith(f"could not write {store.root}")
    assert "the disk is full; everything saved before is intact, free some space and run again" in message
    assert "\n" not in message
    assert files_below(store.root) == before
    assert store.lane().head == head


def test_another_refusal_gives_its_own_reason(tmp_path):
    """Not the advice to free space, where a file stands in the way of a folder."""
    (tmp_path / "taken").write_bytes(b"")
    with pytest.raises(MechStyleError) as caught:
        write_whole(tmp_path / "taken" / "run" / "part.json", b"{}")
    message = str(caught.value)
    assert "could not write" in message
    assert "Not a directory" in message
    assert "choose another place" in message
    assert "space" not in message


def test_an_interrupted_write_leaves_the_old_content_and_nothing_else(tmp_path, monkeypatch):
    write_whole(tmp_path / "file", b"old")

    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("pathlib.Path.replace", interrupt)
    with pytest.raises(KeyboardInterrupt):
        write_whole(tmp_path / "file", b"new")
    assert files_below(tmp_path) == {"file": b"old"}


def test_what_a_killed_process_left_half_written_is_not_seen(store):
    store.move("main", Lane(recipe=KEY, head=store.objects.put_record(checkpoint())))
    for folder in ("lanes", "memo", "objects/ab"):
        (store.root / folder).mkdir(exist_ok=True, parents=True)
        (store.root / folder / ".new-x7").write_bytes(b"{")
    assert store.lanes() == ("main",)
    assert len(store.history()) == 1


# --- the memo -----------------------------------------------------------------------------------------------------


def test_memo_recalls_what_it_remembered(store):
    store.memo.remember(KEY, simulation())
    assert_same(store.memo.recall(KEY, Simulation), simulation())


def test_memo_recalls_nothing_it_was_not_told(store):
    assert store.memo.recall(KEY, Simulation) is None
    store.memo.remember(KEY, simulation())
    assert store.memo.recall("6" * 64, Simulation) is None


def test_memo_does_not_recall_a_result_of_another_kind(store):
    store.memo.remember(KEY, "words")
    assert store.memo.recall(KEY, str) == "words"
    assert store.memo.recall(KEY, Simulation) is None


@damaged
@pytest.mark.parametrize("part", ["record", "array"])
def test_a_damaged_result_is_computed_and_remembered_anew(store, damage, part):
    store.memo.remember(KEY, simulation())
    damage(store.objects.path(store.objects.put_record(simulation()) if part == "record" else store.objects.put_array(AWKWARD)))
    assert store.memo.recall(KEY, Simulation) is None
    store.memo.remember(KEY, simulation())
    assert_same(store.memo.recall(KEY, Simulation), simulation())


@pytest.mark.parametrize("content", [b"", b"\xff\xfe", bytes(64), b"not a digest", b"../../lanes/main.json"])
def test_a_damaged_index_is_no_answer_and_is_mended(store, content):
    store.memo.remember(KEY, simulation())
    (store.memo.folder / KEY).write_bytes(content)
    assert store.memo.recall(KEY, Simulation) is None
    store.memo.remember(KEY, simulation())
    assert_same(store.memo.recall(KEY, Simulation), simulation())


def test_a_readable_result_stays(store):
    store.memo.remember(KEY, "first")
    store.memo.remember(KEY, "second")
    assert store.memo.recall(KEY, str) == "first"


FIRST_READ = """
import sys, threading
import msgspec
from mechstyle.loop.objects import from_json, to_json

sys.setswitchinterval(1e-6)
PARTS = 12

def kind(number):
    parts = [msgspec.defstruct(f"Part{number}x{k}", [("a", int), ("b", list[float]), ("c", "dict[str, int]")]) for k in range(PARTS)]
    whole = msgspec.defstruct(f"Whole{number}", [(f"part{k}", part) for k, part in enumerate(parts)])
    return whole, to_json(whole(*(part(1, [2.0], {"d": 3}) for part in parts)))

def read(kind, data, gate):
    gate.wait()
    assert from_json(data, kind).part0.a == 1

for number in range(20):
    made, gate = kind(number), threading.Barrier(6)
    readers = [threading.Thread(target=read, args=(*made, gate)) for _ in range(6)]
    for reader in readers:
        reader.start()
    for reader in readers:
        reader.join()
"""


def test_records_of_a_kind_are_first_read_by_many_threads():
    """A kernel ended without a word when a list of runs was read while a run was opened."""
    done = subprocess.run([sys.executable, "-c", FIRST_READ], capture_output=True, text=True, timeout=120, check=False)
    assert (done.returncode, done.stderr) == (0, "")
