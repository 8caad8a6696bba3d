"""Results of a drop test beyond the stress on the surface: curves over time, their figures, and fields in the body for ParaView."""

from __future__ import annotations

import tempfile
from pathlib import Path

import msgspec
import numpy as np

from mechstyle.errors import BadInput
from mechstyle.fea.drop import Drop, History
from mechstyle.fea.elements import at_vertices
from mechstyle.pictures import fields
from mechstyle.pictures.panels import Picture
from mechstyle.records import Landing
from mechstyle.records.mesh import Floats, TetMesh
from mechstyle.simulation.impact import Impact

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

    @classmethod
    def of(cls, history: History, landing: Landing, impact: Impact, vertices: Floats) -> Course:
        """The figures of a drop, of a landing; `impact` is the same drop on the surface, of `vertices` [mm], shape [vertex_count, 3]."""
        moments = impact.stress[: impact.end]
        frame, vertex = np.unravel_index(np.argmax(moments), moments.shape)
        force, energy = history.contact_force, float(history.kinetic[0])
        given = energy + history.gravity_work[-1]
        starts = history.time[np.searchsorted(history.phase, np.arange(len(landing.touches)))]
        x, y, z = vertices[vertex]
        return cls(
            peak_time=float(impact.time[frame]), peak_where=(float(x), float(y), float(z)), peak_stress=float(impact.stress[frame, vertex]),
            peak_force=float(force.max()), peak_force_time=float(history.time[force.argmax()]),
            contact_time=float(history.time[np.flatnonzero(force > 0.0)].max(initial=0.0)),
            touches=tuple(zip(map(float, starts), landing.touches, strict=True)), ended=landing.ended, energy=energy,
            **{name: float(getattr(history, name)[-1] / given) for name in SHARES},
        )  # fmt: skip

    @property
    def words(self) -> str:
        """Energy balance of the drop, in one sentence."""
        took = f"the floor took {self.contact_loss:.0%}, bending {self.plastic_work:.0%} and damping {self.damping_loss:.0%}"
        left = f"{self.kinetic:.0%} are motion and {self.strain:.0%} strain in the end"
        return f"Of {self.energy:.0f} mJ {took}; {left}."

    @property
    def touch_words(self) -> str:
        """Its touches after the first, and why it was followed no further, in one sentence."""
        again = [f"it touches again after {start:.1f} ms at {speed:.1f} m/s" for start, speed in self.touches[1:]]
        return "; ".join([*again, self.ended]).capitalize() + "."


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


def _with_gaps(history: History, values: Floats) -> tuple[Floats, Floats]:
    """Times and values of a curve that is interrupted where the part flies."""
    flights = np.flatnonzero(np.diff(history.phase)) + 1
    return np.insert(history.time, flights, history.time[flights]), np.insert(values, flights, np.nan)


def vtu_bytes(tets: TetMesh, drop: Drop) -> bytes:
    """The flat landing of a drop test as a VTU file.

    At the vertices: `stays_bent` [mm], `stress`, its running maximum [MPa], and `contact`; in the tetrahedra `von_mises`, the largest at
    their Gauss points [MPa], and `plastic_strain`. Single precision is finer than any of these is, at half the file.
    """
    import meshio  # noqa: PLC0415 — half a second, when a file is wanted

    nodes = {
        "stays_bent": drop.permanent[0].astype(np.float32), "stress": at_vertices(tets, drop.von_mises[0]).astype(np.float32),
        "contact": drop.contact[0].astype(np.uint8),
    }  # fmt: skip
    inside = {"von_mises": [drop.von_mises[0].max(axis=1)], "plastic_strain": [drop.plastic_strain[0].max(axis=1)]}
    with tempfile.TemporaryDirectory() as folder:  # meshio writes to files only
        file = Path(folder) / "part.vtu"
        meshio.Mesh(tets.vertices, [("tetra", tets.tets)], point_data=nodes, cell_data=inside).write(file)
        return file.read_bytes()


def vtu_path(path: str | Path) -> Path:
    """The path of a VTU file to write; BadInput if it does not end in .vtu."""
    target = Path(path)
    if target.suffix.lower() != ".vtu":
        raise BadInput(f"ParaView files are written as VTU: give {target.with_suffix('.vtu')} instead of {target}")
    return target
