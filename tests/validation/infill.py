"""Prints with walls and infill: beam theory and the rule of mixtures, the cell of a gyroid, and infill that is meshed line by line.

What Homrani et al. measured of nine groups of printed bars (Polymers 16, 2024, 2253) stands in a table that was not at hand; only its
abstract was. No print was measured for these cases.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import cg

from mechstyle.fea.discretisation import Relative
from mechstyle.fea.drop import DropTest, drop
from mechstyle.fea.permanent_set import measured
from mechstyle.fea.statics import StaticTest
from mechstyle.records.infill import PATTERNS
from mechstyle.records.load_cases import Load, LoadCase, Patch, Support
from mechstyle.records.material import LIBRARY
from mechstyle.records.mesh import Bools, Floats, TetMesh
from mechstyle.records.recipe import Recipe
from mechstyle.simulation.printed import printed_body
from validation.cases import Result, compared
from validation.meshes import box, lattice

PLA = LIBRARY["PLA"]
BEAM, MIXED, CELL = 0.10, 0.05, 0.15
"""Largest errors of a bent beam, of a bar in tension, and of the cell of an infill."""
SHARE, LENGTH = 0.20, 0.05
"""What stays bent may differ by this share, or by this length [mm]."""
Axes = tuple[Floats, Floats, Floats]


def body_of(tets: TetMesh, **printed: object) -> Relative | None:
    """What a body printed so has of the properties of its plastic."""
    return printed_body(tets, Recipe.of(prompt="", material=PLA, **printed))


# --- theory -----------------------------------------------------------------------------------------------------------


def bars() -> Iterator[Result]:
    """Bars of solid skins or walls around infill: a cantilever of a sandwich, and a bar in tension."""
    for pattern, infill, layers in (("gyroid", 0.15, 5), ("gyroid", 0.4, 3), ("grid", 0.15, 8)):
        yield _bent(pattern, infill, layers)
    for pattern, infill, walls in (("gyroid", 0.15, 3), ("grid", 0.3, 2)):
        yield from _pulled(pattern, infill, walls)


def _bent(pattern: str, infill: float, layers: int) -> Result:
    """The end of a cantilever: bending of skins and core, and shear of the core (Timoshenko; Allen 1969)."""
    long, wide, high, force = 80.0, 10.0, 8.0, 4.0
    tets, skin = box((32, 4, 5), (long, wide, high)), 0.2 * layers
    relative = body_of(tets, infill=infill, infill_pattern=pattern, walls=0, top=layers, bottom=layers)
    case = _clamped(tets, (0.0, 0.0, -force))
    found = StaticTest(tets, (case,)).run(tets, PLA, relative=relative)[case.name].displacement
    end = np.flatnonzero((tets.vertices[:, 0] > long - 1e-6) & (np.abs(tets.vertices[:, 2] - 0.5 * high) < 0.11 * high))
    core, (_, soft, _) = high - 2.0 * skin, PATTERNS[pattern].relative(infill)
    stiff = PLA.youngs_modulus * wide * (high**3 - (1.0 - soft) * core**3) / 12.0
    sheared = soft * PLA.shear_modulus * wide * (0.5 * (high + core)) ** 2 / core
    expected = force * long**3 / (3.0 * stiff) + force * long / sheared
    name = f"bars: {infill:.0%} {pattern} between skins of {skin:g} mm, deflection"
    return compared(name, float(-found[end, 2].mean()), expected, BEAM, "mm", "bending of skins and core, and shear of the core")


def _pulled(pattern: str, infill: float, walls: int) -> Iterator[Result]:
    """Stiffness and yield load of a bar that is pulled, by what walls and infill have of its section."""
    long, side = 60.0, 10.0
    tets, wall = box((15, 5, 5), (long, side, side)), 0.42 * walls
    caps = {"top": 30, "bottom": 30, "build_direction": (1.0, 0.0, 0.0)}  # solid ends of 6 mm, which share the force out
    relative = body_of(tets, infill=infill, infill_pattern=pattern, walls=walls, **caps)
    core = (side - 2.0 * wall) ** 2
    _, soft, weak = PATTERNS[pattern].relative(infill)
    stiff, bears = side**2 - (1.0 - soft) * core, PLA.yield_strength * (side**2 - (1.0 - weak) * core)
    case = _clamped(tets, (0.7 * bears, 0.0, 0.0))
    static, x = StaticTest(tets, (case,)), tets.vertices[:, 0]
    moved = static.run(tets, PLA, relative=relative)[case.name].displacement[: len(x), 0]
    ends = [moved[np.abs(x - at) < 1e-6].mean() for at in (20.0, 40.0)]
    found = 0.7 * bears * 20.0 / (PLA.youngs_modulus * (ends[1] - ends[0]))
    name = f"bars: {walls} walls around {infill:.0%} {pattern}, "
    yield compared(f"{name}stiffness in tension", float(found), stiff, MIXED, "mm²", "rule of mixtures, E A over E of PLA")
    factor = static.loaded(tets, PLA, tolerance=0.2, relative=relative)[case.name].result.factor
    yield compared(f"{name}load at yield", 0.7 * bears * factor, bears, 2.0 * MIXED, "N", "rule of mixtures; 0.2 mm stay of 48 mm")


def _clamped(tets: TetMesh, force: tuple[float, float, float]) -> LoadCase:
    """One end held, a force on the other."""
    far = float(tets.vertices[:, 0].max())
    near, end = Patch(plane=(0.0, 0.0, 0.0, -1.0, 0.0, 0.0)), Patch(plane=(far, 0.0, 0.0, 1.0, 0.0, 0.0))
    return LoadCase(name="load", supports=(Support(at=near),), loads=(Load(at=end, force=force),))


# --- the cell of an infill --------------------------------------------------------------------------------------------

VOXELS = 32


def cell() -> Iterator[Result]:
    """Stiffness of a gyroid, one sheet of plastic thick, beside the law for it."""
    for density in (0.15, 0.3):
        found = cell_stiffness(gyroid_sheet(VOXELS, density))
        name, note = (
            f"cell: gyroid of {density:.0%}, E over that of PLA",
            f"periodic cell of {VOXELS}³ voxels, mean over all directions (Hill 1952)",
        )
        yield compared(name, PATTERNS["gyroid"].relative(density)[1], found, CELL, "", note)


def gyroid_sheet(count: int, density: float) -> Bools:
    """Voxels nearest to the surface sin x cos y + sin y cos z + sin z cos x = 0 that fill a share of a cell, shape [count] * 3."""
    axis = (np.arange(count) + 0.5) / count * 2.0 * np.pi
    x, y, z = np.meshgrid(axis, axis, axis, indexing="ij")
    surface = np.sin(x) * np.cos(y) + np.sin(y) * np.cos(z) + np.sin(z) * np.cos(x)
    slope = np.hypot(np.hypot(np.cos(x) * np.cos(y) - np.sin(z) * np.sin(x), np.cos(y) * np.cos(z) - np.sin(x) * np.sin(y)),
                     np.cos(z) * np.cos(x) - np.sin(y) * np.sin(z))  # fmt: skip
    distance = np.abs(surface) / np.maximum(slope, 1e-6)
    return np.asarray(distance <= np.quantile(distance, density))


def cell_stiffness(solid: Bools) -> float:
    """Young's modulus of a periodic cubic cell over that of its solid, alike to all directions by Hill's mean.

    Voxels are trilinear elements with Wilson's incompatible modes (Taylor, Beresford and Wilson 1976).
    """
    count, (stiffness, loads, own) = len(solid), _voxel()
    corners = np.array(list(itertools.product((0, 1), repeat=3)))
    nodes = (np.argwhere(solid)[:, None] + corners) % count
    _, number = np.unique((nodes[..., 0] * count + nodes[..., 1]) * count + nodes[..., 2], return_inverse=True)
    unknowns = (3 * number.reshape(-1, 8, 1) + np.arange(3)).reshape(-1, 24)
    size = int(unknowns.max()) + 1
    rows, columns = np.repeat(unknowns, 24, axis=1).ravel(), np.tile(unknowns, (1, 24)).ravel()
    matrix = sparse.coo_array((np.tile(stiffness.ravel(), len(unknowns)), (rows, columns)), shape=(size, size)).tocsr()
    diagonal = matrix.diagonal()
    matrix = matrix + sparse.diags_array(1e-7 * diagonal)  # against motion as a whole
    mean = np.empty((6, 6))
    forces = np.stack([np.bincount(unknowns.ravel(), np.tile(loads[:, strain], len(unknowns)), size) for strain in range(6)], axis=1)
    for strain in (0, 3):
        moved, _ = cg(matrix, -forces[:, strain], M=sparse.diags_array(1.0 / diagonal).tocsr(), rtol=1e-5, maxiter=4000)
        mean[:, strain] = (own[:, strain] * len(unknowns) + forces.T @ moved) / count**3
    along, across, shear = mean[0, 0], 0.5 * (mean[1, 0] + mean[2, 0]), mean[3, 3]
    bulk, other = (along + 2.0 * across) / 3.0, 0.5 * (along - across)
    rigid = 0.5 * ((2.0 * other + 3.0 * shear) / 5.0 + 5.0 / (2.0 / other + 3.0 / shear))
    return float(9.0 * bulk * rigid / (3.0 * bulk + rigid) / PLA.youngs_modulus)


def _voxel() -> tuple[Floats, Floats, Floats]:
    """Stiffness [24, 24], loads of unit strains [24, 6] and their stiffness [6, 6] of a unit cube of PLA."""
    elastic = PLA.lame_lambda * np.pad(np.ones((3, 3)), (0, 3)) + PLA.shear_modulus * np.diag([2.0, 2.0, 2.0, 1.0, 1.0, 1.0])
    ends = 2.0 * np.array(list(itertools.product((0, 1), repeat=3))) - 1.0
    whole = np.zeros((39, 39))
    for point in ends / np.sqrt(3.0):
        shapes = np.array([[0.25 * end[i] * np.prod(np.delete(1.0 + end * point, i)) for i in range(3)] for end in ends])
        strains = np.hstack([_strains(np.vstack([shapes, np.diag(-4.0 * point)])), np.eye(6)])
        whole += strains.T @ elastic @ strains / 8.0
    outer, inner = np.r_[:24, 33:39], np.arange(24, 33)
    condensed = whole[np.ix_(outer, outer)] - whole[np.ix_(outer, inner)] @ np.linalg.solve(
        whole[np.ix_(inner, inner)], whole[np.ix_(inner, outer)]
    )
    return condensed[:24, :24], condensed[:24, 24:], condensed[24:, 24:]


def _strains(slopes: Floats) -> Floats:
    """Strains xx yy zz yz zx xy of nodes with these gradients of their shapes, shape [6, 3 nodes]."""
    rows = [[[x, 0, 0], [0, y, 0], [0, 0, z], [0, z, y], [z, 0, x], [y, x, 0]] for x, y, z in slopes]
    return np.concatenate(np.array(rows), axis=1)


# --- infill line by line ----------------------------------------------------------------------------------------------

LINE, WALLS, LAYERS, GAP = 0.45, 2, 4, 6.0
"""Width of a line [mm], walls, solid layers of 0.2 mm, and way between the lines of the grid [mm], of which 15 % is plastic."""
PARTS = {
    "block": ((21.6, 21.6, 16.0), (0.15, 0.1, 1.0), 3000.0),
    "bar": ((14.0, 14.0, 50.0), (0.25, 0.1, 1.0), 1500.0),
    "plate": ((50.0, 32.0, 8.0), (0.06, 0.04, 1.0), 3000.0),
}
"""Parts: their sizes [mm], floor normals and heights of fall [mm]."""


def grids() -> Iterator[Result]:
    """Three parts with walls, skins and a grid, each line meshed, beside the same smeared out: what stays bent after a fall."""
    for name, (size, normal, height) in PARTS.items():
        test, printed = DropTest(height=height), {"walls": WALLS, "line_width": LINE, "top": LAYERS, "bottom": LAYERS, "infill": 0.15}
        lines = line_by_line(size)
        smeared = box((round(size[0] / 2.0), round(size[1] / 2.0), round(size[2] / 2.0)), size)
        sets = []
        for tets, relative in ((lines, None), (smeared, body_of(smeared, infill_pattern="grid", **printed))):
            found = drop(tets, PLA, [normal], test, device="cpu", relative=relative)
            density = 1.0 if relative is None else relative.density
            sets.append(measured(tets, found.permanent[0], found.tension_strain[0], density).permanent_set)
        reference, ours = sets
        limit = max(SHARE, LENGTH / reference)
        yield compared(
            f"grids: {name}", ours, reference, limit, "mm", f"{len(lines.tets)} tetrahedra, each line meshed; {len(smeared.tets)} smeared"
        )


def line_by_line(size: Sequence[float]) -> TetMesh:
    """A box with walls, skins and the lines of a grid along x and y, which are as high as it is."""
    wall, skin = WALLS * LINE, LAYERS * 0.2
    axes, in_lines = [], []
    for length in size[:2]:
        first = 0.5 * (length % GAP) if length % GAP > 2.0 * wall + 1.0 else 0.5 * (length % GAP + GAP)
        middles = np.arange(first, length - wall - 1.0, GAP)
        planes = np.concatenate([[0.0, wall, length - wall, length], middles - 0.5 * LINE, middles + 0.5 * LINE])
        axes.append(_filled(np.sort(planes)))
        in_lines.append(middles)
    up = _filled(np.array([0.0, skin, size[2] - skin, size[2]]))
    whole = lattice(*axes, up)
    x, y, z = whole.vertices[whole.tets].mean(axis=1).T
    solid = (z < skin) | (z > size[2] - skin)
    for at, length, middles in ((x, size[0], in_lines[0]), (y, size[1], in_lines[1])):
        solid |= (at < wall) | (at > length - wall) | (np.abs(at[:, None] - middles) < 0.5 * LINE).any(axis=1)
    used, corners = np.unique(whole.tets[solid], return_inverse=True)
    return TetMesh(whole.vertices[used], corners.reshape(-1, 4).astype(np.int32))


def _filled(planes: Floats) -> Floats:
    """Planes with others between them, no further than 1.5 mm apart."""
    parts = [np.linspace(low, high, max(round((high - low) / 1.5), 1), endpoint=False) for low, high in itertools.pairwise(planes)]
    return np.append(np.concatenate(parts), planes[-1])
