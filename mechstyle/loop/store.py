"""The run on disk: objects named by the SHA-256 of their content, one movable reference per lane, and a memo of simulations.

Layout of a run directory:

    objects/ab/cdef…    arrays (.npy bytes) and records (JSON), each zlib-compressed, never changed once written
    lanes/main.json     where a lane stands: its recipe, its newest checkpoint, where it was forked
    memo/0123…          digest of the result of a computation, named by the digest of its inputs
    locks/main.lock     which process carries the lane on
    summaries/…         what a finished lane came to

Everything is written aside and renamed, so a process killed at any moment loses at most the iteration in flight.
"""

from __future__ import annotations

import contextlib
import re
from pathlib import Path
from typing import Any, TypeVar

import msgspec

from mechstyle._files import exclusive, write_whole
from mechstyle.errors import BadInput, DamagedStore, absent, unknown
from mechstyle.loop.objects import Memo, Objects, read_record
from mechstyle.records import Checkpoint, Recipe, Verdict

T = TypeVar("T")

FOLDERS = ("objects", "lanes", "memo", "locks", "summaries")
"""Of a run directory."""

ANOTHER = "this run was made by another version of MechStyle; run it again in another folder"

GONE = (("restraint", "until_sure"), ("test", "hardest_only"), ("test", "rough"))
"""Settings of recipes of older runs."""


class Lane(msgspec.Struct, frozen=True, kw_only=True):
    """A lane: the recipe in force, its newest checkpoint and its fork.

    Attributes:
        recipe: Digest of the recipe its new iterations follow.
        head: Digest of its newest checkpoint, "" before the first.
        forked_from: Digest of the checkpoint it was branched at, "" for an original line.
    """

    recipe: str
    head: str = ""
    forked_from: str = ""


class Entry(msgspec.Struct, frozen=True, kw_only=True):
    """A checkpoint without its arrays: what a log needs. Fields as in `Checkpoint`."""

    iteration: int
    parent: str
    recipe: str
    simulated_at: int
    style_loss: float
    reason: str
    verdict: Verdict | None
    final: bool
    digest: str = ""


class Store:
    """One run directory: checkpoints, lanes, recipes, meshes and the memo of its simulations."""

    def __init__(self, root: str | Path) -> None:
        """Use `root`, which is created by the first write; DamagedStore if a folder in it is a link.

        A run that somebody else sent could have written, and `gc` removed, what is wherever the link leads.
        """
        self._written = Path(root)
        self._folder = _absolute(self._written)
        for folder in FOLDERS:
            if (self.root / folder).is_symlink():
                raise DamagedStore(f"{self.root / folder} is a link, and a run is kept in one folder: put what it leads to in its place")
        self.objects = Objects(self._folder / "objects")  # whoever holds on to them goes on wherever the process goes
        self.memo = Memo(self._folder / "memo", self.objects)
        # by their content: whatever is written meanwhile, they stay what they are
        self._entries: dict[str, Entry] = {}
        self._recipes: dict[str, Recipe] = {}

    @property
    def root(self) -> Path:
        """The folder as it was written, for people to know it again; absolute once the process works elsewhere, where that leads astray."""
        return self._written if _absolute(self._written) == self._folder else self._folder

    @property
    def place(self) -> Path:
        """The folder, absolute: by this a run is known, wherever the process works meanwhile."""
        return self._folder

    @classmethod
    def open(cls, root: str | Path) -> Store:
        """An existing run directory, or BadInput."""
        store = cls(root)
        if not store.place.exists():
            raise absent(root)
        if not store.lanes():
            raise BadInput(f"{root} is not a run directory: it holds no lanes/*.json; give the folder that `mechstyle run --out` wrote")
        return store

    def lanes(self) -> tuple[str, ...]:
        """Names of the lanes, `main` first, then in order of name."""
        names = (path.stem for path in self._lane_files() if path.is_file() and not path.is_symlink())
        return tuple(sorted(names, key=lambda name: (name != "main", name)))

    def _lane_files(self) -> list[Path]:
        return [path for path in (self.root / "lanes").glob("*.json") if _may_be_a_lane(path.stem)]

    def lane(self, name: str = "main") -> Lane:
        """A lane by name; BadInput for a lane that is not there."""
        path = self.root / "lanes" / f"{name}.json"
        if path not in self._lane_files():
            raise unknown(f"lane in {self.root}", name, self.lanes())
        _check_plain(path)
        return read_record(path, Lane)

    def check_lanes(self) -> None:
        """Refuse, with BadInput, a folder in which something that is no lane stands in the place of one: a lane may have been there."""
        for path in self._lane_files():
            _check_plain(path)

    def move(self, name: str, lane: Lane) -> None:
        """Point a lane somewhere; names are letters, digits, dots, dashes and underscores, but no number: `DIR@120` is an iteration."""
        if not _may_be_a_lane(name):
            rest = "hold only letters, digits, '.', '-' and '_', and not be a number"
            raise BadInput(f"lane name {name!r} must begin with a letter or digit, {rest}")
        write_whole(self.root / "lanes" / f"{name}.json", msgspec.json.encode(lane))

    def branching(self, *, wait: bool = True) -> contextlib.AbstractContextManager[None]:
        """Hold off other branches, or two could take one name, and `gc`, to which what no lane names yet is garbage.

        BadInput if somebody else does and this is not to `wait`.
        """
        return exclusive(self.root / "locks" / ".branches.lock", f"a new branch of {self.root}", wait=wait)

    def fork(self, lane: Lane, wanted: str = "") -> str:
        """Name of a lane with this recipe and fork: of the one that is there, under the wanted name if there is one, or of a new one.

        What it names is to be stored, and this called, within one `branching`. BadInput if the name wanted is that of another lane.
        """
        known = {name: self.lane(name) for name in self.lanes()}
        for name, other in known.items():
            if wanted in ("", name) and (other.recipe, other.forked_from) == (lane.recipe, lane.forked_from):
                return name
        name = wanted or next(f"branch-{number}" for number in range(1, len(known) + 2) if f"branch-{number}" not in known)
        if name in known:
            raise BadInput(f"lane {name!r} of {self.root} has other settings or another fork; choose another name")
        self.move(name, lane)
        return name

    def put_recipe(self, recipe: Recipe) -> str:
        """Store a recipe; its digest is the recipe's own."""
        return self.objects.put(msgspec.json.encode(recipe, order="deterministic"))

    def recipe(self, digest: str) -> Recipe:
        """A stored recipe, without the settings that are gone: where it had some, its own digest is another one; it is read once."""
        if digest not in self._recipes:
            self._recipes[digest] = self._read_recipe(digest)
        return self._recipes[digest]

    def _read_recipe(self, digest: str) -> Recipe:
        table = self.record(digest, dict[str, dict[str, Any]])
        for chapter, name in GONE:
            table.get(chapter, {}).pop(name, None)
        material = table.get("test", {}).get("material")
        if isinstance(material, dict):
            material.pop("ductile", None)
        try:
            return msgspec.convert(table, Recipe, strict=False)
        except msgspec.ValidationError as error:
            raise BadInput(f"{self.root}: {ANOTHER}") from error

    def record(self, digest: str, kind: type[T]) -> T:
        """A stored record of the given type; BadInput for one that is whole, but not as this version writes it."""
        try:
            return self.objects.get_record(digest, kind)
        except DamagedStore as error:
            if isinstance(error.__cause__, msgspec.ValidationError):
                raise BadInput(f"{self.root}: {ANOTHER}") from error
            raise

    def checkpoint(self, digest: str) -> Checkpoint:
        """A stored checkpoint with its arrays."""
        return self.record(digest, Checkpoint)

    def entry(self, digest: str) -> Entry:
        """A stored checkpoint without its arrays; it is read once, as who looks at one looks back at all before it."""
        if digest not in self._entries:
            self._entries[digest] = msgspec.structs.replace(self.record(digest, Entry), digest=digest)
        return self._entries[digest]

    def is_finished(self, name: str = "main") -> bool:
        """Whether a lane's newest checkpoint is the end of the recipe in force."""
        lane = self.lane(name)
        if not lane.head:
            return False
        entry = self.entry(lane.head)
        return entry.final and (entry.recipe == lane.recipe or self.recipe(entry.recipe) == self.recipe(lane.recipe))

    def history(self, lane: str = "main") -> list[Entry]:
        """All checkpoints of a lane, its inherited past included, oldest first."""
        entries, digest = [], self.lane(lane).head
        while digest:
            entries.append(self.entry(digest))
            digest = entries[-1].parent
        return entries[::-1]

    def verdict(self, state: Checkpoint | Entry) -> Verdict | None:
        """The newest verdict there, None before the first."""
        verdict, parent = state.verdict, state.parent
        while verdict is None and parent:
            entry = self.entry(parent)
            verdict, parent = entry.verdict, entry.parent
        return verdict

    def find(self, iteration: int | None, lane: str = "main") -> Entry:
        """The newest checkpoint of an iteration in a lane (None: its head); BadInput says which iterations there are."""
        if isinstance(iteration, str):
            raise BadInput(f"{iteration!r} is no iteration, which is a whole number; what is to be shown goes into fields=[{iteration!r}]")
        history = self.history(lane)
        if not history:
            raise BadInput(f"lane {lane!r} in {self.root} has no checkpoint yet")
        if iteration is None:
            return history[-1]
        for entry in reversed(history):
            if entry.iteration == iteration:
                return entry
        raise BadInput(
            f"iteration {iteration} is not in lane {lane!r} of {self.root}: it holds {history[0].iteration} to {history[-1].iteration}"
        )


def _absolute(path: Path) -> Path:
    try:
        return path.absolute()
    except OSError:  # the working directory was removed
        return path


def _check_plain(path: Path) -> None:
    """Refuse what is not a file itself: in a folder from somebody else a link could lead to any file of the user's."""
    if not path.is_file() or path.is_symlink():
        raise BadInput(f"{path} is not a file, as a lane is: remove it if you do not know what it is for, or restore the file from a copy")


def _may_be_a_lane(name: str) -> bool:
    return not name.isdigit() and re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9._-]*", name) is not None


def parse_address(address: str) -> tuple[Path, str, int | None]:
    """Split `DIR`, `DIR@ITERATION`, `DIR@LANE` or `DIR@LANE:ITERATION` into directory, lane and iteration; a folder of that name is DIR."""
    root, at, place = address.rpartition("@")
    if not at or "/" in place or "\\" in place or Path(address).is_dir():  # an @ in the name of a folder is no address
        return Path(address), "main", None
    lane, colon, number = place.rpartition(":")
    if not (colon or re.fullmatch("[0-9]+", number)):
        lane, number = number, ""
    if not re.fullmatch("[0-9]*", number):
        raise BadInput(f"{address!r}: {number!r} is not an iteration; write DIR@120 or DIR@lane:120")
    return Path(root), lane or "main", int(number) if number else None
