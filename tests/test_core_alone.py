"""An installation without extras: what trimesh and others load only when it is needed is there."""

from __future__ import annotations

import importlib.metadata
import importlib.util
import subprocess
import sys
import tomllib

from packaging.utils import canonicalize_name

from support import ROOT
from support.part_files import PART, exported, glb_with_node, put, threemf_in

_SPEC = importlib.util.spec_from_file_location("licences", ROOT / "benchmarks/licences.py")
licences = importlib.util.module_from_spec(_SPEC)
_SPEC.loader.exec_module(licences)

READ = """
import sys

class Refuse:
    def find_spec(self, name, path, target=None):
        if name.partition(".")[0] in {missing!r}:
            raise ModuleNotFoundError(f"No module named {{name!r}}: no dependency of the core brings it")

sys.meta_path.insert(0, Refuse())
from mechstyle.errors import BadInput
from mechstyle.geometry.files import read
for path in sys.argv[1:]:
    try:
        print(len(read(path).mesh.faces), "faces")
    except BadInput as error:
        print("refused:", error)
"""
FILES = {
    "latin.obj": "# Höhe in mm\n".encode("latin-1") + exported("obj"),
    "picture.stl": b"\x89PNG\r\n\x1a\n" + b"IHDR" * 40,
    "part.stl": exported("stl"),
    "part.ply": exported("ply"),
    "part.glb": glb_with_node(),
    "part.3mf": threemf_in("millimeter", 1.0),
}


def test_files_are_read_or_refused_where_nothing_but_the_core_is_installed(tmp_path):
    core = licences.reached(tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["dependencies"]) | {"mechstyle"}
    owners = importlib.metadata.packages_distributions()
    missing = {module for module, names in owners.items() if not core & set(map(canonicalize_name, names))}
    paths = [str(put(tmp_path, name, content)) for name, content in FILES.items()]
    done = subprocess.run([sys.executable, "-c", READ.format(missing=missing), *paths], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    told = [f"refused: {name} is a picture" if name == "picture.stl" else f"{len(PART.faces)} faces" for name in FILES]
    assert [line[: len(words)] for line, words in zip(done.stdout.splitlines(), told, strict=True)] == told
