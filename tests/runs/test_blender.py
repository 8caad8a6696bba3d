"""The script that Blender runs reads a run folder as MechStyle does; Blender itself is a stand-in."""

import ast
import runpy
import sys
from types import SimpleNamespace
from unittest.mock import MagicMock

import numpy as np
import pytest

from support import ROOT
from support.lanes import lane_on_a_sheet

SCRIPT = ROOT / "docs" / "blender.py"


@pytest.fixture
def script():
    return SimpleNamespace(**runpy.run_path(str(SCRIPT)))


@pytest.fixture
def run(tmp_path):
    return lane_on_a_sheet(tmp_path / "run", iterations=12, gain=200.0)


def test_it_needs_blender_and_numpy_only():
    nodes = list(ast.walk(ast.parse(SCRIPT.read_text(encoding="utf-8"))))
    imported = {name.name.split(".")[0] for node in nodes if isinstance(node, ast.Import) for name in node.names}
    imported |= {node.module.split(".")[0] for node in nodes if isinstance(node, ast.ImportFrom)}
    assert imported <= {*sys.stdlib_module_names, "numpy", "bpy"}


@pytest.mark.parametrize("iteration", [None, 0, 7])
def test_it_reads_what_mechstyle_reads(script, run, iteration):
    found, state = script.loaded(run.store.root, "main", iteration), run.checkpoint(iteration)
    assert np.allclose(found["vertices"], run.surface(iteration).vertices, atol=1e-9)
    assert np.array_equal(found["faces"], run.part.surface.faces)
    assert np.array_equal(found["fields"]["stress_MPa"], state.stress)
    assert np.array_equal(found["fields"]["mask"], state.mask)
    assert (found["iteration"], found["name"]) == (state.iteration, "sheet")


def test_it_makes_attributes_of_the_fields(script, run, monkeypatch):
    blender = MagicMock()
    monkeypatch.setitem(sys.modules, "bpy", blender)
    script.show(script.loaded(run.store.root))
    mesh = blender.data.meshes.new.return_value
    assert {call.args[0] for call in mesh.attributes.new.call_args_list} == set(script.FIELDS.values())
    assert len(mesh.from_pydata.call_args.args[0]) == 64


def test_a_damaged_or_missing_iteration_is_said(script, run):
    with pytest.raises(ValueError, match="never reached iteration 99"):
        script.loaded(run.store.root, "main", 99)
    path = run.store.objects.path(run.history[-1].digest)
    path.write_bytes(run.store.objects.path(run.history[0].digest).read_bytes())
    with pytest.raises(ValueError, match="is damaged"):
        script.loaded(run.store.root)
