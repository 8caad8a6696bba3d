"""A run judged by an older measure: it opens, says so wherever it is shown, and is tested again when it is carried on."""

import msgspec
import pytest

from mechstyle.loop.store import Lane
from mechstyle.records import Simulation
from mechstyle.records.verdict import OLDER
from mechstyle.runs.run import Run
from support.lanes import carry_on, lane_on_a_sheet

FIGURES = {"permanent_set", "plastic_strain", "place", "factor", "landing_strain", "landing_set", "load_strain", "load_set"}
"""What an older simulation did not know."""


def older(value, gone=FIGURES):
    """A stored record as an older version wrote it."""
    if isinstance(value, dict):
        return {name: older(one, gone) for name, one in value.items() if name not in gone}
    return [older(one, gone) for one in value] if isinstance(value, list) else value


@pytest.fixture
def run(tmp_path):
    """A finished lane whose verdicts compare stress, whose recipe has settings that are gone, and whose simulations know no bend."""
    run = lane_on_a_sheet(tmp_path / "run", iterations=6, every=3)
    objects = run.store.objects

    def table(digest):
        return msgspec.json.decode(objects.get(digest))

    recipe = table(run.store.lane().recipe)
    recipe["test"] |= {"hardest_only": True, "rough": False, "material": {**recipe["test"]["material"], "ductile": True}}
    del recipe["test"]["tolerance"]
    recipe["restraint"]["until_sure"] = True
    kept, parent = objects.put(msgspec.json.encode(recipe)), ""
    for entry in run.history:
        state = table(entry.digest) | {"parent": parent, "recipe": kept}
        state["simulation"] = objects.put(msgspec.json.encode(older(table(state["simulation"]))))
        if state["verdict"]:
            rows = [{"test": "flat", "landing": "flat", "outcome": "HOLDS", "stress": 30.0, "limit": 45.6, "height": 2000.0}]
            state["verdict"] = older(state["verdict"], {"measure", "tolerance"}) | {"rows": rows, "outcome": "HOLDS"}
        parent = objects.put(msgspec.json.encode(state))
    run.store.move("main", Lane(recipe=kept, head=parent))
    return Run(run.store, "main", "cpu")


def test_it_opens_and_nothing_of_it_is_called_to_hold(run, tmp_path):
    assert run.finished
    assert (run.verdict.outcome, run.verdict.failure) == ("UNKNOWN", OLDER)
    assert (run.summary.outcome, run.summary.rows) == ("UNKNOWN", ())
    assert run.simulation().stress.max() > 20.0
    page = run.report(tmp_path / "report.html").read_text()
    assert "judged by an older measure" in page
    assert "HOLDS a fall" not in page
    assert run.show().png.startswith(b"\x89PNG")


def test_carried_on_it_is_tested_again(run):
    run.store.move("main", msgspec.structs.replace(run.store.lane(), recipe=run.store.put_recipe(run.recipe)))
    before = len(run.history)
    carry_on(run)
    assert run.finished
    assert run.verdict.rows[0].permanent_set > 0.0
    assert len(run.history) <= before + 1
    assert run.store.objects.get_record(run.checkpoint().simulation, Simulation).set_of(landing="flat").any()
