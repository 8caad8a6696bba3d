"""A pipe where a file should be."""

import os

import pytest

from mechstyle.errors import DamagedStore
from mechstyle.loop.objects import read_record
from mechstyle.loop.store import Store


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs pipes")
def test_a_pipe_in_the_place_of_a_file_is_refused(tmp_path):
    """Read, it would wait for ever: a folder from somebody else hung every command that opened it."""
    store = Store(tmp_path / "run")
    digest = store.objects.put(b"content")
    for path in (store.root / "part.json", store.objects.path(digest), store.root / "memo" / ("5" * 64)):
        path.unlink(missing_ok=True)
        path.parent.mkdir(exist_ok=True)
        os.mkfifo(path)
    with pytest.raises(DamagedStore, match=r"part\.json is not a file: restore it from a copy"):
        read_record(store.root / "part.json", dict)
    with pytest.raises(DamagedStore, match="is not a file: restore it from a copy"):
        store.objects.get(digest)
    assert store.memo.recall("5" * 64, float) is None
    assert store.memo.named() == []
