"""Names as they may stand in paths: whatever somebody called a part, a file named after it lies in the folder it was meant for."""

import itertools
import ntpath
import posixpath
import sys
import unicodedata

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mechstyle._files import cache_folder, clip_folder, file_stem, write_aside

RESERVED = ("CON", "PRN", "AUX", "NUL", "COM1", "com9", "LPT1", "nul.txt", "aux.tar.gz", "con ")


@pytest.mark.parametrize("name", ["cup", "pen_holder", "hook-2", "Tasse größe (3)", "a.b", "花瓶", "it's"])
def test_an_ordinary_name_stays_as_it_is(name):
    assert file_stem(name) == name


@pytest.mark.parametrize(
    "name",
    ["../../x", "/etc/x", "..\\..\\x", "C:\\x", "C:x", "\\\\host\\share\\x", "a\nb\0", "a\x1b[31mb", "a\u202egnp.exe", "a:stream", ".."],
)  # fmt: skip
def test_a_name_that_would_lead_elsewhere_does_not(name, tmp_path):
    stem = file_stem(name)
    assert posixpath.basename(stem) == ntpath.basename(stem) == stem
    assert not ntpath.splitdrive(stem)[0]
    assert (tmp_path / f"{stem}-main.png").resolve().parent == tmp_path.resolve()


@pytest.mark.parametrize("name", ["", " ", "...", "/", "\0", "\n\t"])
def test_what_is_no_name_becomes_part(name):
    assert file_stem(name) == "part"


@pytest.mark.parametrize("name", RESERVED)
def test_names_that_windows_keeps_for_devices_are_changed(name):
    assert file_stem(name).split(".")[0].strip().upper() not in {other.split(".")[0].strip().upper() for other in RESERVED}


@given(st.text(max_size=400))
def test_any_text_becomes_one_short_name(name):
    stem = file_stem(name)
    assert 0 < len(stem.encode()) <= 120
    assert not set('<>:"/\\|?*') & set(stem)
    assert not any(unicodedata.category(letter)[0] == "C" for letter in stem)
    assert stem == stem.strip(" .")
    assert file_stem(stem) == stem


def test_a_cache_that_cannot_be_written_to_stands_in_nobodys_way(tmp_path, monkeypatch):
    """Every command that prepares a part was refused. A file in its place refuses the administrator, too, as a read-only disk does."""
    (tmp_path / "file").touch()
    monkeypatch.setenv("MECHSTYLE_CACHE", str(tmp_path / "file" / "cache"))
    (cache_folder() / "part").write_text("prepared")
    assert (cache_folder() / "part").read_text() == "prepared", "for as long as this process lasts"
    assert clip_folder() == tmp_path / "file" / "cache" / "clip", "weights are looked for where they were told to be"
    monkeypatch.setenv("MECHSTYLE_CACHE", str(tmp_path / "new"))
    assert cache_folder() == tmp_path / "new"


def interrupted_at(number):
    """A tracer that presses Ctrl-C before a line of `write_aside`, counted from 0 as they are run."""
    lines = itertools.count()

    def step(_, event, __):
        if event == "line" and next(lines) == number:
            sys.settrace(None)
            raise KeyboardInterrupt
        return step

    return lambda frame, _, __: step if frame.f_code is write_aside.__code__ else None


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # a file that is not closed yet is, by Python
def test_whoever_ends_a_write_at_any_line_of_it_finds_the_old_file_or_the_new_one_alone(tmp_path):
    """A run that was asked to end between making a file and remembering its name left it behind."""
    path, tracing = tmp_path / "file", sys.gettrace()
    for number in itertools.count():
        path.write_bytes(b"old")
        sys.settrace(interrupted_at(number))
        try:
            write_aside(path, b"new")
        except KeyboardInterrupt:
            assert list(tmp_path.iterdir()) == [path], f"line {number}"
            assert path.read_bytes() in (b"old", b"new")
        else:
            break
        finally:
            sys.settrace(tracing)
    assert number > 4
    assert path.read_bytes() == b"new"
