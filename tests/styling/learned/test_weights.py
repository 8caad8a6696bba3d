"""Weights are fetched only when asked to, kept with their checksums, and never used unverified."""

import shutil

import huggingface_hub
import pytest

from mechstyle.errors import BadInput, MissingPiece
from mechstyle.styling.learned.weights import FILES, KNOWN, SUMS, fetch, located, stored, verified


@pytest.fixture(autouse=True)
def _nothing_of_ones_own(monkeypatch):
    monkeypatch.delenv("MECHSTYLE_CLIP", raising=False)


@pytest.fixture
def hub(tiny_clip):
    """A hub that hands out a tiny model and remembers what was asked of it."""
    asked = []

    def download(repository, file, folder):
        asked.append((repository, file))
        shutil.copy(tiny_clip / file, folder / file)
        return ""

    download.asked = asked
    return download


def test_fetching_stores_the_files_with_checksums_that_sha256sum_reads(tmp_path, hub):
    found = fetch("ViT-B-32", tmp_path, hub)
    assert found.folder == tmp_path / "ViT-B-32"
    assert sorted(path.name for path in found.folder.iterdir()) == sorted([*FILES, SUMS])
    assert [line.split("  ")[1] for line in (found.folder / SUMS).read_text().splitlines()] == list(FILES)
    assert hub.asked == [(KNOWN["ViT-B-32"], file) for file in FILES]
    assert stored(tmp_path) == [found.folder]


def test_what_is_there_is_not_fetched_again_unless_it_is_damaged(tmp_path, hub):
    first = fetch("ViT-B-32", tmp_path, hub)
    assert fetch("ViT-B-32", tmp_path, hub) == first
    assert len(hub.asked) == len(FILES)
    (first.folder / "vocab.json").write_text("{}")
    assert fetch("ViT-B-32", tmp_path, hub) == first
    assert len(hub.asked) == 2 * len(FILES)


def test_what_the_hub_did_not_publish_is_not_kept(tmp_path, hub):
    with pytest.raises(BadInput, match="arrived damaged: fetch it again"):
        fetch("ViT-B-32", tmp_path, lambda *of: hub(*of) or "0" * 64)
    assert stored(tmp_path) == []
    with pytest.raises(MissingPiece):
        located("ViT-B-32", tmp_path)


def test_an_interrupted_fetch_is_not_taken_for_weights(tmp_path, hub):
    def breaks(repository, file, folder):
        if file == FILES[2]:
            raise KeyboardInterrupt
        return hub(repository, file, folder)

    with pytest.raises(KeyboardInterrupt):
        fetch("ViT-B-32", tmp_path, breaks)
    assert stored(tmp_path) == []
    assert fetch("ViT-B-32", tmp_path, hub).folder.is_dir()


@pytest.mark.parametrize("wanted", ["", "ViT-B-32", "ViT-B-32@" + "0" * 64])
def test_missing_weights_are_one_sentence_with_the_command_and_the_offline_alternative(tmp_path, wanted):
    with pytest.raises(MissingPiece) as caught:
        located(wanted, tmp_path)
    sentence = str(caught.value)
    assert "`mechstyle weights fetch ViT-B-32`" in sentence
    assert "guidance 'offline'" in sentence
    assert "\n" not in sentence


def test_a_damaged_file_is_named(tmp_path, hub):
    folder = fetch("ViT-B-32", tmp_path, hub).folder
    (folder / "merges.txt").write_text("#version: 0.3\n")
    with pytest.raises(BadInput, match=r"merges\.txt is not the file listed in its .*: run `mechstyle weights fetch ViT-B-32` again"):
        located("ViT-B-32", tmp_path)


def test_a_folder_of_ones_own_is_used_and_recognised(tmp_path, tiny_clip, monkeypatch):
    monkeypatch.setenv("MECHSTYLE_CLIP", str(tiny_clip))
    found = located("", tmp_path)
    assert found == verified(tiny_clip)
    assert located(found.identity, tmp_path) == found
    with pytest.raises(MissingPiece, match=f"{tiny_clip.name}@0+, with which this run was made, are not on this machine"):
        located(f"{tiny_clip.name}@{'0' * 64}", tmp_path)


def test_a_folder_is_named_in_a_run_and_found_again_without_naming_it(tmp_path, tiny_clip):
    """A run's folder is opened by other commands and other processes: branch, export, report."""
    found = located(str(tiny_clip), tmp_path / "store")
    assert located(found.identity, tmp_path / "store") == found
    with pytest.raises(MissingPiece, match="name their folder with --clip"):
        located(found.identity, tmp_path / "another machine")


def test_a_folder_that_has_changed_since_is_told(tmp_path, tiny_clip):
    folder = tmp_path / "clip"
    shutil.copytree(tiny_clip, folder)
    recorded = located(str(folder), tmp_path).identity
    (folder / "config.json").write_text((folder / "config.json").read_text() + "\n")
    with pytest.raises(MissingPiece, match="are not on this machine"):
        located(recorded, tmp_path)


class ConnectionLost(Exception):
    """What the hub's client raises without network is of its HTTP library, and no OSError."""


def test_without_network_fetching_says_one_sentence(tmp_path, monkeypatch):
    def lost(*_args, **_settings):
        raise ConnectionLost("[Errno -2] Name or service not known\nFor more information, see elsewhere")

    monkeypatch.setattr(huggingface_hub.HfApi, "file_exists", lost)
    with pytest.raises(MissingPiece) as caught:
        fetch("ViT-B-32", tmp_path)
    assert str(caught.value) == (
        "config.json of openai/clip-vit-base-patch32 could not be fetched ([Errno -2] Name or service not known): "
        "check the connection and try again"
    )
    assert stored(tmp_path) == []
