"""The run on disk: lanes and their histories, where a lane stands, and how a place in a run is addressed."""

import os
from pathlib import Path

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mechstyle.errors import BadInput, DamagedStore
from mechstyle.loop.garbage import collect
from mechstyle.loop.store import Lane, Store, parse_address
from mechstyle.records import Recipe
from mechstyle.records.material import LIBRARY
from support.records import VERDICT, checkpoint, recipe

KEY = "5" * 64


@pytest.fixture
def store(tmp_path):
    return Store(tmp_path / "run")


# --- lanes --------------------------------------------------------------------------------------------------------


def chain(store, iterations, parent=""):
    """Checkpoints on top of each other; their digests."""
    digests = []
    for iteration in iterations:
        parent = store.objects.put_record(checkpoint(iteration, parent=parent, style_loss=float(len(digests))))
        digests.append(parent)
    return digests


@pytest.fixture
def forked(store):
    """`main` holds 0 to 5 and 5 again (a correction); `other` leaves it at 3 and holds 4' and 5'."""
    main = chain(store, [0, 1, 2, 3, 4, 5, 5])
    store.move("main", Lane(recipe=KEY, head=main[-1]))
    other = chain(store, [4, 5], parent=main[3])
    store.move("other", Lane(recipe="6" * 64, head=other[-1], forked_from=main[3]))
    return store, main, other


def test_a_relative_folder_is_found_from_another_working_directory(tmp_path, monkeypatch):
    """A run that was made with a relative folder, as by default, was dead after os.chdir, and went on into a stray folder."""
    monkeypatch.chdir(tmp_path)
    store = Store("run")
    [head] = chain(store, [0])
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    monkeypatch.chdir(elsewhere)
    store.move("main", Lane(recipe=KEY, head=head))
    store.memo.remember("1" * 64, 2.5)
    assert [entry.digest for entry in store.history()] == [head]
    assert list(elsewhere.iterdir()) == []


def test_a_folder_is_called_as_it_was_written_while_it_leads_there(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    store = Store("run")
    assert store.root == Path("run")
    monkeypatch.chdir("/")
    assert store.root == tmp_path / "run"
    monkeypatch.chdir(tmp_path)
    assert store.root == Path("run")


def odd(path, kind):
    """Put something in a lane's place that is none."""
    if kind == "folder":
        path.mkdir()
    elif kind == "pipe":
        os.mkfifo(path)
    else:
        path.symlink_to(path.parent / ("none.json" if kind == "dangling link" else "main.json"))


KINDS = ("folder", "dangling link", "link", *(("pipe",) if hasattr(os, "mkfifo") else ()))


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_no_file_in_the_place_of_a_lane_is_none(kind, forked):
    """One such entry blocked log and gc with "unknown lane 'l': did you mean 'l'?"."""
    store, main, _ = forked
    odd(store.root / "lanes" / "l.json", kind)
    assert store.lanes() == ("main", "other")
    assert [entry.digest for entry in store.history()] == main
    with pytest.raises(BadInput, match=r"l\.json is not a file, as a lane is: remove it"):
        store.lane("l")


@pytest.mark.parametrize("kind", KINDS)
def test_gc_removes_nothing_while_a_lane_may_be_missing(kind, forked):
    store, *_ = forked
    odd(store.root / "lanes" / "l.json", kind)
    litter = store.objects.path(store.objects.put(b"litter"))
    with pytest.raises(BadInput, match=r"l\.json is not a file, as a lane is: remove it"):
        collect(store)
    assert litter.is_file()


def test_history_runs_from_the_original_to_the_head(forked):
    store, main, _ = forked
    assert [entry.digest for entry in store.history()] == main
    assert [entry.iteration for entry in store.history()] == [0, 1, 2, 3, 4, 5, 5]


def test_history_of_a_branch_begins_with_its_inherited_past(forked):
    store, main, other = forked
    assert [entry.digest for entry in store.history("other")] == main[:4] + other


def test_history_tells_what_a_log_needs(store):
    one = checkpoint(verdict=VERDICT, reason="last iteration", final=True, recipe=KEY, simulated_at=3)
    digest = store.objects.put_record(one)
    entry = store.entry(digest)
    assert entry.digest == digest
    for name in ("iteration", "parent", "recipe", "simulated_at", "style_loss", "reason", "verdict", "final"):
        assert getattr(entry, name) == getattr(one, name)


def test_a_lane_without_a_checkpoint_has_no_history(store):
    store.move("main", Lane(recipe=KEY))
    assert store.history() == []
    with pytest.raises(BadInput, match=r"lane 'main' in .* has no checkpoint yet"):
        store.find(None)


def test_find_gives_the_newest_of_an_iteration(forked):
    store, main, other = forked
    assert store.find(2).digest == main[2]
    assert store.find(5).digest == main[6]
    assert store.find(None).digest == main[6]
    assert store.find(2, "other").digest == main[2]
    assert store.find(5, "other").digest == other[1]


@pytest.mark.parametrize("iteration", [-1, 6, 120])
def test_find_says_which_iterations_there_are(forked, iteration):
    store = forked[0]
    with pytest.raises(BadInput, match=f"iteration {iteration} is not in lane 'other' of .*: it holds 0 to 5$"):
        store.find(iteration, "other")


def test_a_lane_comes_back_as_it_was_moved(store):
    lane = Lane(recipe="a", head="b", forked_from="c")
    store.move("main", lane)
    assert store.lane() == lane
    store.move("main", msgspec.structs.replace(lane, head="d"))
    assert store.lane().head == "d"


def test_a_lane_is_finished_when_its_head_is_the_end_of_its_own_recipe(store):
    wish = Recipe.of(prompt="brick", material=LIBRARY["PLA"], iterations=40)
    own, longer = store.put_recipe(wish), store.put_recipe(wish.with_settings(iterations=80))
    store.move("main", Lane(recipe=own))
    assert not store.is_finished()
    store.move("main", Lane(recipe=own, head=store.objects.put_record(checkpoint(recipe=own))))
    assert not store.is_finished()
    end = store.objects.put_record(checkpoint(recipe=own, final=True))
    store.move("main", Lane(recipe=own, head=end))
    assert store.is_finished()
    store.move("longer", Lane(recipe=longer, head=end, forked_from=end))
    assert not store.is_finished("longer")


def test_a_lane_stays_finished_when_recipes_have_got_a_setting_more(store):
    """Begun again, it was at its end and said for ever to be carried on by the same command."""
    wish = Recipe.of(prompt="brick", material=LIBRARY["PLA"], iterations=40)
    before = msgspec.to_builtins(wish)
    del before["printed"]
    older = store.objects.put(msgspec.json.encode(before, order="deterministic"))
    end = store.objects.put_record(checkpoint(recipe=older, final=True))
    store.move("main", Lane(recipe=store.put_recipe(wish), head=end))
    assert older != store.put_recipe(wish)
    assert store.is_finished()


def test_main_is_the_first_of_the_lanes(store):
    for name in ("zebra", "main", "apple", "Branch-1"):
        store.move(name, Lane(recipe=KEY))
    assert store.lanes() == ("main", "Branch-1", "apple", "zebra")


def test_a_missing_lane_is_refused_with_the_known_ones(forked):
    store = forked[0]
    with pytest.raises(BadInput, match=r"unknown lane in .* 'othr': did you mean 'other'\? known are other, main"):
        store.lane("othr")


@pytest.mark.parametrize("name", ["main", "branch-1", "a", "2x", "v1.2", "Thick_walls"])
def test_lane_names_that_are_accepted(store, name):
    store.move(name, Lane(recipe=KEY))
    assert store.lanes() == (name,)


@pytest.mark.parametrize("name", ["", "../main", "a/b", "a b", "a:3", "a@b", ".hidden", "-x", "_x", "é", "main\n", "120"])
def test_lane_names_that_are_refused_with_nothing_written(store, name):
    """A number among them: `DIR@120` is an iteration."""
    with pytest.raises(BadInput, match=r"^lane name .* must begin with a letter or digit") as caught:
        store.move(name, Lane(recipe=KEY))
    assert repr(name) in str(caught.value)
    assert not store.root.exists()


def test_a_store_is_opened_where_there_are_lanes_only(store, tmp_path):
    (tmp_path / "file").write_bytes(b"")
    for place, why in ((store.root, "does not exist"), (tmp_path, "is not a run directory"), (tmp_path / "file", "is not a run directory")):
        with pytest.raises(BadInput, match=why):
            Store.open(place)
    store.move("main", Lane(recipe=KEY))
    assert Store.open(str(store.root)).lanes() == ("main",)


def test_reading_writes_nothing(tmp_path):
    store = Store(tmp_path / "nowhere")
    assert store.lanes() == ()
    assert store.memo.recall(KEY, str) is None
    assert not store.root.exists()


# --- addresses ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("address", "root", "lane", "iteration"),
    [
        ("DIR", "DIR", "main", None),
        ("DIR@", "DIR", "main", None),
        ("DIR@120", "DIR", "main", 120),
        ("DIR@0", "DIR", "main", 0),
        ("DIR@:120", "DIR", "main", 120),
        ("DIR@lane", "DIR", "lane", None),
        ("DIR@lane:", "DIR", "lane", None),
        ("DIR@lane:120", "DIR", "lane", 120),
        ("DIR@2x", "DIR", "2x", None),
        ("a/b.c d/DIR@branch-1:7", "a/b.c d/DIR", "branch-1", 7),
        ("me@home/DIR", "me@home/DIR", "main", None),
        ("me@home/DIR@120", "me@home/DIR", "main", 120),
        ("me@home/DIR@lane:120", "me@home/DIR", "lane", 120),
        ("DIR@v2@main", "DIR@v2", "main", None),
        (r"C:\me@home\DIR", r"C:\me@home\DIR", "main", None),
        (r"C:\DIR@5", r"C:\DIR", "main", 5),
    ],
)
def test_addresses_say_directory_lane_and_iteration(address, root, lane, iteration):
    assert parse_address(address) == (Path(root), lane, iteration)


@pytest.mark.parametrize("address", ["DIR@lane:x", "DIR@lane:-1", "DIR@lane:1.5", "DIR@:x", "DIR@lane:²", "DIR@lane:٣"])
def test_an_address_without_a_proper_iteration_is_refused_with_the_forms_there_are(address):
    with pytest.raises(BadInput) as caught:
        parse_address(address)
    assert str(caught.value).endswith("is not an iteration; write DIR@120 or DIR@lane:120")
    assert repr(address) in str(caught.value)


@pytest.mark.parametrize("name", ["mug@home", "part@120", "part@lane:3"])
def test_a_folder_with_an_at_in_its_name_is_opened_by_its_name(tmp_path, name):
    (tmp_path / name).mkdir()
    assert parse_address(str(tmp_path / name)) == (tmp_path / name, "main", None)
    assert parse_address(f"{tmp_path / name}@thin:7") == (tmp_path / name, "thin", 7)


@given(address=st.text(st.sampled_from("aZ09@:/.-²٣ \\"), max_size=12))
def test_any_text_is_an_address_or_is_refused(address):
    try:
        root, lane, iteration = parse_address(address)
    except BadInput:
        return
    assert isinstance(root, Path)
    assert lane
    assert iteration is None or iteration >= 0


@given(
    root=st.text(st.sampled_from("ab/@."), min_size=1).filter(lambda text: text == str(Path(text))),
    lane=st.from_regex(r"[a-z][a-z0-9-]{0,8}", fullmatch=True),
    iteration=st.integers(0, 10**6),
)
def test_a_full_address_is_read_as_it_was_written(root, lane, iteration):
    assert parse_address(f"{root}@{lane}:{iteration}") == (Path(root), lane, iteration)


# --- other versions -----------------------------------------------------------------------------------------------


EARLIER = {
    "a recipe": lambda store: [store.objects.put_record(checkpoint(0)), store.objects.put(b'{"surface":"5","tilts":3}')],
    "a verdict": lambda store: [store.objects.put_record({**ENTRY, "verdict": {"outcome": "VIABLE", "words": "It holds."}}), KEY],
}
ENTRY = {"iteration": 0, "parent": "", "recipe": "", "simulated_at": 0, "style_loss": 0.5, "reason": "original part", "final": False}


@pytest.mark.parametrize("what", EARLIER)
def test_a_run_of_another_version_is_refused_in_one_sentence(store, what):
    head, recipe = EARLIER[what](store)
    store.move("main", Lane(recipe=recipe, head=head))
    with pytest.raises(BadInput) as caught:
        _ = store.recipe(store.lane().recipe) if what == "a recipe" else store.history()
    said = str(caught.value)
    assert said == f"{store.root}: this run was made by another version of MechStyle; run it again in another folder"


def test_a_record_that_is_damaged_is_not_taken_for_one_of_another_version(store):
    digest = store.put_recipe(recipe())
    store.objects.path(digest).write_bytes(b"rust")
    with pytest.raises(DamagedStore, match="restore it from a copy"):
        store.recipe(digest)
