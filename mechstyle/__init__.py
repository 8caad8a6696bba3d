"""MechStyle: stylize a 3D-printable model from a prompt while a drop test watches its strength.

    import mechstyle as ms
    run = ms.stylize(ms.load("part.stl"), "brick", material="PLA")
    run.verdict
    run.show()

Units everywhere: mm, g, ms, N, MPa. Importing this package loads nothing; everything comes when asked for. What studies, plug-ins and
teaching need besides is in `mechstyle.lab`.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mechstyle.errors import BadInput, MechStyleError
    from mechstyle.gallery import load
    from mechstyle.gallery.style_sheet import styles
    from mechstyle.geometry.files import save
    from mechstyle.records import Recipe, Verdict
    from mechstyle.records.load_cases import Load, LoadCase, Support
    from mechstyle.records.material import LIBRARY, Material
    from mechstyle.records.mesh import SurfaceMesh
    from mechstyle.records.regions import Box, HalfSpace, Sphere
    from mechstyle.runs.printing import Printing
    from mechstyle.runs.protection import protect
    from mechstyle.runs.run import Run, stylize
    from mechstyle.runs.stylizers import register_stylizer
    from mechstyle.simulation.part_test import PartTest, simulate
    from mechstyle.simulation.strengthen import strengthen

__version__ = "0.1.0"

_WHERE = {name: module for module, names in {
    "errors": "BadInput MechStyleError",
    "gallery": "load",
    "gallery.style_sheet": "styles",
    "geometry.files": "save",
    "records": "Recipe Verdict",
    "records.load_cases": "Load LoadCase Support",
    "records.material": "LIBRARY Material",
    "records.mesh": "SurfaceMesh",
    "records.regions": "Box HalfSpace Sphere",
    "runs.printing": "Printing",
    "runs.protection": "protect",
    "runs.run": "Run stylize",
    "runs.stylizers": "register_stylizer",
    "simulation.part_test": "PartTest simulate",
    "simulation.strengthen": "strengthen",
}.items() for name in names.split()}  # fmt: skip

__all__ = [
    "LIBRARY", "BadInput", "Box", "HalfSpace", "Load", "LoadCase", "Material", "MechStyleError", "PartTest", "Printing", "Recipe", "Run",
    "Sphere", "Support", "SurfaceMesh", "Verdict", "lab", "load", "protect", "register_stylizer", "save", "simulate",
    "strengthen", "styles", "stylize",
]  # fmt: skip


def _found(names: dict[str, Any], where: dict[str, str], name: str) -> Any:
    """Load a public name of a module on first use."""
    value = getattr(import_module(f"mechstyle.{where[name]}"), name)
    names[name] = value
    return value


def __getattr__(name: str) -> Any:
    """Load what is asked for on first use."""
    if name in _WHERE:
        return _found(globals(), _WHERE, name)
    second = import_module("mechstyle.lab")
    if name == "lab":
        return second
    if name in second.__all__:
        return getattr(second, name)
    raise AttributeError(f"module 'mechstyle' has no attribute {name!r}")


def __dir__() -> list[str]:
    """Every public name, loaded or not."""
    return [*__all__, "__version__"]
