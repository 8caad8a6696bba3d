"""Results of a drop test beyond the stress on the surface: curves over time, their figures, and fields in the body for ParaView."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from numpy.typing import ArrayLike

from mechstyle.errors import BadInput
from mechstyle.fea.drop import Drop, History
from mechstyle.fea.elements import EDGES, ElementMesh
from mechstyle.fea.permanent_set import at_nodes
from mechstyle.fea.snapshots import Snapshot
from mechstyle.pictures import fields
from mechstyle.pictures.panels import Picture
from mechstyle.records.mesh import Floats, TetMesh
from mechstyle.simulation.impact import Impact, nearest_rigid

SHARES = ("kinetic", "strain", "plastic_work", "contact_loss", "damping_loss")
"""Where the energy of a drop is in the end, as `History` has it."""


class Course(msgspec.Struct, frozen=True, kw_only=True):
    """The drop as placed over time, in figures.

    Attributes:
        peak_time: When the stress at the surface was highest anywhere, to a frame of the impact [ms since first touch].
        peak_where: Vertex of the surface where it was, in the undeformed part [mm].
        peak_stress: What it was there [MPa].
        peak_force: Largest mean normal force of the floor over a sample [N].
        peak_force_time: When [ms].
        contact_time: Until when the floor pushed last [ms].
        touches: When each phase of the drop began [ms], with the speed of the touching point [mm/ms = m/s].
        ended: Why it was followed no further, in words.
        energy: Kinetic energy at first touch [mJ].
        kinetic: Share of that, and of the work of weight since, that is kinetic energy at the end.
        strain: Share that is strain energy then.
        plastic_work: Share that bending for good took.
        contact_loss: Share that the floor took.
        damping_loss: Share that damping took.
        balance_error: Largest error of the balance over the drop, as a share; measured without damping. None if that drop failed.
    """

    peak_time: float
    peak_where: tuple[float, float, float]
    peak_stress: float
    peak_force: float
    peak_force_time: float
    contact_time: float
    touches: tuple[tuple[float, float], ...]
    ended: str
    energy: float
    kinetic: float
    strain: float
    plastic_work: float
    contact_loss: float
    damping_loss: float
    balance_error: float | None

    @classmethod
    def of(cls, dropped: Drop, impact: Impact, vertices: Floats, balance_error: float | None) -> Course:
        """The figures of a drop.

        Args:
            dropped: The first orientation is looked at.
            impact: The same drop on the surface.
            vertices: Of the surface [mm], shape [vertex_count, 3].
            balance_error: Of `simulator.Detail`.
        """
        moments = impact.stress[: impact.end]
        frame, vertex = np.unravel_index(np.argmax(moments), moments.shape)
        history = dropped.history[0]
        force = history.contact_force
        energy = float(history.kinetic[0])
        given = energy + history.gravity_work[-1]
        x, y, z = vertices[vertex]
        return cls(
            peak_time=float(impact.time[frame]),
            peak_where=(float(x), float(y), float(z)),
            peak_stress=float(impact.stress[frame, vertex]),
            peak_force=float(force.max()),
            peak_force_time=float(history.time[force.argmax()]),
            contact_time=float(history.time[np.flatnonzero(force > 0.0)].max(initial=0.0)),
            touches=tuple((phase.start, phase.speed) for phase in dropped.phases[0]),
            ended=dropped.endings[0],
            energy=energy,
            **{name: float(getattr(history, name)[-1] / given) for name in SHARES},
            balance_error=balance_error,
        )

    @property
    def words(self) -> str:
        """Energy balance of the drop, in one sentence."""
        took = f"the floor took {self.contact_loss:.0%}, bending {self.plastic_work:.0%} and damping {self.damping_loss:.0%}"
        left = f"{self.kinetic:.0%} are motion and {self.strain:.0%} strain in the end"
        return f"Of {self.energy:.0f} mJ {took}; {left}; {self.balance_words}."

    @property
    def touch_words(self) -> str:
        """Its touches after the first, and why it was followed no further, in one sentence."""
        again = [f"it touches again after {start:.1f} ms at {speed:.1f} m/s" for start, speed in self.touches[1:]]
        return "; ".join([*again, self.ended]).capitalize() + "."

    @property
    def balance_words(self) -> str:
        """Error of the energy balance, in words."""
        if self.balance_error is None:
            return "the balance could not be checked, as the drop without damping failed"
        kept = "within" if self.balance_error <= 0.01 else "NOT within"
        return f"without damping the balance closes to {100 * self.balance_error:.1g} %, {kept} 1 %"


def history_picture(history: History, impact: Impact, course: Course, strength: float) -> Picture:
    """Largest stress, energies and contact force of the drop as placed over time.

    Args:
        history: Of the drop as placed.
        impact: The same drop on the surface.
        course: Its figures.
        strength: Yield strength [MPa].
    """
    from mechstyle.pictures.plots import Curve, Plot, plots_png  # noqa: PLC0415 — matplotlib is loaded when a picture is wanted

    (x, y, z), end = course.peak_where, impact.end
    stress = Plot(
        fields.moment(strength).label.capitalize(), "MPa",
        [Curve("at the surface", impact.time[:end], impact.stress[:end].max(axis=1), stepped=True)],
        limit=(strength, f"yields at {strength:.1f} MPa"), mark=(course.peak_time, course.peak_stress),
        words=f"highest by {course.peak_time:.2f} ms, at ({x:.1f}, {y:.1f}, {z:.1f}) mm",
    )  # fmt: skip
    named = (
        ("kinetic", "kinetic"), ("strain", "strain"), ("plastic_work", "taken by bending"), ("contact_loss", "taken by the floor"),
        ("damping_loss", "taken by damping"),
    )  # fmt: skip
    energy = Plot("Energy", "mJ", [Curve(label, *_with_gaps(history, getattr(history, name))) for name, label in named])
    force = Plot(
        "Contact force", "N", [Curve("floor", *_with_gaps(history, history.contact_force), stepped=True)],
        mark=(course.peak_force_time, course.peak_force),
        words=f"up to {course.peak_force:.0f} N, the last of it at {course.contact_time:.2f} ms",
    )  # fmt: skip
    note = f"{course.words} {course.touch_words}"
    return Picture(plots_png([stress, energy, force], x_label="time since first touch [ms]", title="The drop as placed", note=note))


def history_figures(history: History) -> dict[str, list[float]]:
    """The curves of the drop as placed, by name; units as in `History`."""
    return {name: np.asarray(getattr(history, name)).tolist() for name in History.__dataclass_fields__}


def vtu_bytes(tets: TetMesh, drop: Drop, at: Snapshot, *, each: bool = False) -> bytes:
    """A drop test as a VTU file.

    At the nodes: `displacement` at the moment of the peak [mm], fall and all, and `deformation`, the same less rigid motion; `stays_bent`
    after the flat landing [mm], its `stress` [MPa] and `contact`; over several landings `stress_envelope`, their largest [MPa]. In the
    cells: `von_mises`, the running maximum at the Gauss points [MPa], `plastic_strain`, and `von_mises_envelope`.

    Args:
        tets: The body that was dropped.
        drop: What was found.
        at: The moment whose displacement is shown.
        each: Whether stress and contact of every landing are added, with its number among the landings.
    """
    mesh = at.mesh
    fields = np.stack([at_nodes(tets, mesh.element.at_corners(points)) for points in drop.von_mises])
    cells = drop.von_mises.max(axis=2)

    def spread(values: Any) -> Floats:
        return on_nodes(mesh, np.asarray(values)[at.vertices])

    def touched(contact: Any) -> np.ndarray:
        return (spread(contact) > 0.99).astype(np.uint8)  # between two corners that did

    nodes: dict[str, Any] = {
        "displacement": at.displacement,
        "deformation": mesh.nodes + at.displacement - nearest_rigid(mesh.nodes, mesh.nodes + at.displacement),
        "stays_bent": np.stack([spread(drop.permanent[0][:, axis]) for axis in range(3)], axis=1),
        "stress": spread(fields[0]),
        "contact": touched(drop.contact[0]),
    }
    inside: dict[str, Any] = {"von_mises": cells[0], "plastic_strain": drop.plastic_strain[0].max(axis=1)}
    if len(cells) > 1:
        nodes["stress_envelope"] = spread(fields.max(axis=0))
        inside["von_mises_envelope"] = cells.max(axis=0)
    for number in range(len(cells) if each else 0):
        nodes[f"stress_{number:02}"] = spread(fields[number])
        nodes[f"contact_{number:02}"] = touched(drop.contact[number])
        inside[f"von_mises_{number:02}"] = cells[number]
    return vtu(mesh, _single(nodes), _single(inside))


def _single(fields: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Single precision is finer than any of these figures is, at half the file."""
    return {name: values if values.dtype == np.uint8 else values.astype(np.float32) for name, values in fields.items()}


def _with_gaps(history: History, values: Floats) -> tuple[Floats, Floats]:
    """Times and values of a curve that is interrupted where the part flies."""
    flights = np.flatnonzero(np.diff(history.phase)) + 1
    return np.insert(history.time, flights, history.time[flights]), np.insert(values, flights, np.nan)


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
