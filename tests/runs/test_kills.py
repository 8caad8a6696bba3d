"""A few of the kills of `make test-trust`: whatever a run is stopped by, it goes on to the bytes of one that nobody stopped."""

import json
import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from mechstyle.cli.finished import report_command
from mechstyle.cli.inspect_run import log_command, show_command
from mechstyle.errors import MechStyleError
from mechstyle.loop.store import Store
from mechstyle.runs.run import Run
from support import ROOT
from support.faults import Steps, failing_at
from support.kills import contents, on_a_sheet


@pytest.mark.slow
def test_runs_that_are_killed_or_refused_the_disk_end_in_the_bytes_of_a_whole_one(tmp_path):
    paths = os.pathsep.join([str(ROOT), str(ROOT / "tests")])
    environment = {**os.environ, "PYTHONPATH": paths}  # its block is meshed for other tests as well
    command = [sys.executable, "-m", "support.kills", str(tmp_path / "runs"), "7", "9", "1"]
    told = json.loads(subprocess.run(command, env=environment, stdout=subprocess.PIPE, check=True).stdout)
    for kind in ("sheet", "block"):
        assert told[kind]["wrong"] == []
        assert told[kind]["counts"]["ends compared"] >= 1
    assert sum(count for what, count in told["sheet"]["counts"].items() if what.startswith("killed")) == 9
    assert told["clocks"]
    assert told["side by side"] == {"first": 0, "second": 2, "equal": 1, "lanes": 1}


@pytest.fixture
def whole(tmp_path):
    on_a_sheet(tmp_path / "whole")
    return contents(tmp_path / "whole")


@pytest.fixture
def halfway(tmp_path):
    """A run whose disk was full from some iteration on."""
    with failing_at(Steps("ENOSPC", 250, lasting=True)), pytest.raises(MechStyleError, match="the disk is full"):
        on_a_sheet(tmp_path / "run")
    return tmp_path / "run"


def test_a_run_folder_that_was_zipped_and_moved_goes_on_to_the_same_bytes(halfway, whole, tmp_path):
    packed = Path(shutil.make_archive(str(tmp_path / "packed"), "zip", halfway))
    shutil.rmtree(halfway)
    with zipfile.ZipFile(packed) as archive:
        archive.extractall(tmp_path / "another machine" / "größer [1]")
    moved = tmp_path / "another machine" / "größer [1]"
    assert 5 < Store.open(moved).history()[-1].iteration < 20
    on_a_sheet(moved)
    assert contents(moved) == whole


@pytest.mark.slow
def test_a_folder_on_a_disk_that_cannot_be_written_to_is_read_all_the_same(tmp_path, capsys):
    root, out = on_a_sheet(tmp_path / "run").store.root, tmp_path / "out"
    before = contents(root)
    with failing_at(Steps("EROFS", 0, lasting=True)), pytest.raises(SystemExit) as left:
        show_command(str(root), None)
    assert left.value.code == 2
    assert "Read-only file system" in capsys.readouterr().err
    with failing_at(Steps("EROFS", 0, lasting=True)):
        log_command(str(root))
        assert Store.open(root).find(25).final
        assert Run.open(root, "cpu").show().png.startswith(b"\x89PNG")
    show_command(str(root), out / "picture.png")
    report_command(str(root), out / "page.html")
    assert contents(root) == before


def test_what_is_refused_by_the_disk_is_one_sentence_and_leaves_no_scraps(halfway):
    full = r"the disk is full; everything saved before is intact, free some space"
    with failing_at(Steps("ENOSPC", 1)), pytest.raises(MechStyleError, match=full):
        on_a_sheet(halfway)
    assert not list(halfway.rglob(".new-*"))
