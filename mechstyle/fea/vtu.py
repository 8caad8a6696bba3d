"""Finite element results as a VTU file, for ParaView and everything else that reads VTK."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from mechstyle.errors import BadInput
from mechstyle.fea.elements import EDGES, ElementMesh
from mechstyle.records.mesh import Floats

VTK_ORDER = {4: (0, 1, 2, 3), 10: (0, 1, 2, 3, 4, 7, 5, 6, 8, 9)}
"""Our node in each place of a VTK cell: VTK goes around the base, edges 01 12 20, and then up, 03 13 23."""

CELLS = {4: "tetra", 10: "tetra10"}


def vtu(mesh: ElementMesh, at_nodes: Mapping[str, ArrayLike], in_cells: Mapping[str, ArrayLike]) -> bytes:
    """The content of a VTU file, quadratic elements as quadratic cells.

    Args:
        mesh: The elements.
        at_nodes: Fields by name, shape [node_count] or [node_count, 3].
        in_cells: Fields by name, shape [tet_count].
    """
    import meshio  # noqa: PLC0415 — half a second, when a file is wanted

    nodes = mesh.element.nodes
    point_data = {name: np.ascontiguousarray(values) for name, values in at_nodes.items()}
    cell_data = {name: [np.ascontiguousarray(values)] for name, values in in_cells.items()}
    cells = [(CELLS[nodes], mesh.connectivity[:, VTK_ORDER[nodes]])]
    with tempfile.TemporaryDirectory() as folder:  # meshio writes to files only
        file = Path(folder) / "part.vtu"
        meshio.Mesh(mesh.nodes, cells, point_data=point_data, cell_data=cell_data).write(file)
        return file.read_bytes()


def vtu_path(path: str | Path) -> Path:
    """The path of a VTU file to write; BadInput if it does not end in .vtu."""
    target = Path(path)
    if target.suffix.lower() != ".vtu":
        raise BadInput(f"ParaView files are written as VTU: give {target.with_suffix('.vtu')} instead of {target}")
    return target


def on_nodes(mesh: ElementMesh, values: ArrayLike) -> Floats:
    """A field that is linear in each element at its nodes, shape [node_count], from its values at the vertices, shape [vertex_count]."""
    at_vertices = np.asarray(values, dtype=np.float64)
    found = np.empty(len(mesh.nodes))
    found[: len(at_vertices)] = at_vertices
    if mesh.element.nodes > 4:
        found[mesh.connectivity[:, 4:]] = at_vertices[mesh.tets.tets[:, EDGES]].mean(axis=2)
    return found
