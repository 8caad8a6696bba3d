"""Weights are fetched only when asked to, kept with their checksums, and never used unverified."""

import shutil

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


def test_an_unknown_name_gets_the_nearest(tmp_path, hub):
    for ask in (lambda: located("ViT-B32", tmp_path), lambda: fetch("ViT-B32", tmp_path, hub)):
        with pytest.raises(BadInput, match="unknown CLIP model 'ViT-B32': did you mean 'ViT-B-32'"):
            ask()


def test_weights_are_found_by_name_and_by_what_a_recipe_recorded(tmp_path, hub):
    fetched = fetch("ViT-B-32", tmp_path, hub)
    assert fetched.identity.startswith("ViT-B-32@")
    assert located("", tmp_path) == located("ViT-B-32", tmp_path) == located(fetched.identity, tmp_path) == fetched


def test_a_damaged_file_is_named(tmp_path, hub):
    folder = fetch("ViT-B-32", tmp_path, hub).folder
    (folder / "merges.txt").write_text("#version: 0.3\n")
    with pytest.raises(BadInput, match=r"merges\.txt is not the file that was fetched: run `mechstyle weights fetch ViT-B-32` again"):
        located("ViT-B-32", tmp_path)


def test_a_folder_of_ones_own_is_used_and_recognised(tmp_path, tiny_clip, monkeypatch):
    monkeypatch.setenv("MECHSTYLE_CLIP", str(tiny_clip))
    found = located("", tmp_path)
    assert found == verified(tiny_clip)
    assert located(found.identity, tmp_path) == found
    with pytest.raises(BadInput, match="this run was made with the CLIP weights"):
        located(f"{tiny_clip.name}@{'0' * 64}", tmp_path)


def test_the_identity_depends_on_the_content_only(tmp_path, tiny_clip):
    copy = tmp_path / tiny_clip.name
    shutil.copytree(tiny_clip, copy)
    assert verified(copy).identity == verified(tiny_clip).identity
    (copy / "config.json").write_text((copy / "config.json").read_text() + "\n")
    assert verified(copy).identity != verified(tiny_clip).identity


def test_a_folder_without_weights_says_what_is_missing(tmp_path):
    with pytest.raises(BadInput, match=r"config\.json, merges\.txt, model\.safetensors, vocab\.json missing"):
        verified(tmp_path)
