"""Printability of a styled surface: folded and crossing faces, and a relief lowered to be without, thinnest wall, change of mass."""

from __future__ import annotations

from typing import Any

import msgspec
import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from mechstyle.errors import BadInput
from mechstyle.geometry.cancelling import CancelCheck, never_cancel
from mechstyle.geometry.filaments import LINE
from mechstyle.geometry.proximity import TriangleTree
from mechstyle.geometry.remeshing.crossings import crossings
from mechstyle.geometry.thickness import wall_thickness
from mechstyle.records.mesh import Bools, Field, Floats, SurfaceMesh


class Quality(msgspec.Struct, frozen=True, kw_only=True):
    """A styled surface compared with the part it was made from."""

    folds: int  # faces that look the other way than before: there the relief folded over itself
    crossings: int  # pairs of faces that cross each other without sharing a corner
    crossings_before: int  # the same of the unstylized surface
    thinnest: float  # thinnest wall, thin all over a spot as wide as two lines of plastic [mm]
    thinnest_before: float  # the same of the unstylized surface
    thin: float  # wall thickness that 1 % of the surface falls short of [mm]
    thin_before: float  # the same of the unstylized surface
    volume: float  # volume of the part [mm³]
    volume_change: float  # volume gained over that of the unstylized part
    mass: float  # mass of the part, by the density given [g]
    mass_change: float  # mass gained [g]

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings for the user before printing, one sentence each; empty if all is well."""
        words = []
        if self.folds:
            remedy = "look at the part in the slicer, or style it with less amplitude"
            words.append(f"the relief folded over itself at {self.folds} faces: {remedy}")
        if self.crossings > self.crossings_before:
            words.append(
                f"the style added {self.crossings - self.crossings_before} pairs of faces that cross each other: slicers mostly mend that, "
                f"but look at the part there"
            )
        return tuple(words)


def quality(original: SurfaceMesh, styled: SurfaceMesh, density: float) -> Quality:
    """Compare a styled surface with its original, face by face; `density` in g/mm³; BadInput if the original encloses nothing."""
    if not original.volume > 0.0:
        raise BadInput("the unstylized part encloses nothing, so nobody can print it: begin the run again with a part that is closed")
    trees = [TriangleTree(mesh.vertices, mesh.faces) for mesh in (original, styled)]
    before, after = (mesh.dilated(wall_thickness(mesh, tree)) for mesh, tree in zip((original, styled), trees, strict=True))
    one_percent = len(before) // 100
    return Quality(
        folds=int(turned_over(original, styled).sum()), crossings=crossings(styled, trees[1]).pairs,
        crossings_before=crossings(original, trees[0]).pairs, thinnest=_thinnest(styled, after),
        thinnest_before=_thinnest(original, before), thin=float(np.sort(after)[one_percent]),
        thin_before=float(np.sort(before)[one_percent]), volume=styled.volume, volume_change=styled.volume / original.volume - 1.0,
        mass=density * styled.volume, mass_change=density * (styled.volume - original.volume),
    )  # fmt: skip


def _thinnest(mesh: SurfaceMesh, thickness: Floats) -> float:
    """The least thickness [mm] of which a whole spot two lines wide is, of that at each vertex, shape [vertex_count].

    A ridge of the relief that is narrower is thin, too, and no wall: no nozzle draws it. The spot lies along the surface, because what is
    near in space may be the next wall. Vertices are tried in ascending order, until those left are thicker than a spot that was found.
    """
    (one, other), count = mesh.edges.T, len(mesh.vertices)
    pairs = np.ones(2 * len(one), bool), (np.concatenate([one, other]), np.concatenate([other, one]))
    links, tree, least = sp.csr_array(pairs, shape=(count, count)), cKDTree(mesh.vertices), np.inf
    for vertex in np.argsort(thickness, kind="stable").tolist():
        if thickness[vertex] >= least:
            break
        near, spot, waiting = set(tree.query_ball_point(mesh.vertices[vertex], LINE)), {vertex}, [vertex]
        while waiting:
            at = waiting.pop()
            beside = near.intersection(links.indices[links.indptr[at] : links.indptr[at + 1]].tolist()) - spot
            spot |= beside
            waiting += beside
        least = min(least, float(thickness[list(spot)].max()))
    return float(least)


def turned_over(original: SurfaceMesh, styled: SurfaceMesh) -> Bools:
    """Whether the normal of a face turned over, shape [face_count]: there the relief folded over itself."""
    return np.asarray(np.einsum("ij,ij->i", original.face_vectors, styled.face_vectors) < 0.0)


ROUNDS = 20
"""Times it is looked for crossings; a towel hook in brick needed five, of 200 000 faces and 2138 crossings."""
TAKEN = 0.25
"""Share of the relief that is taken in a round from vertices of faces that cross."""
SPREAD = 2
"""How many edges around them some is taken, ever less, so that the relief has no step there."""


def untangled(surface: SurfaceMesh, relief: Field, go_on: CancelCheck = never_cancel) -> Field:
    """A relief along vertex normals [mm], shape [vertex_count], less what makes faces cross or turn over.

    Faces that cross in the unstylized surface stay as they are, and those left after `ROUNDS` rounds.
    """
    near: Any = None
    share, crossed = np.ones(len(relief), np.float32), crossings(surface).other >= 0
    for _ in range(ROUNDS):
        go_on()
        styled = surface.displaced(relief * share)
        other = np.where(crossed, -1, crossings(styled).other)  # of faces that did not cross before
        tangled = turned_over(surface, styled) | (other >= 0)
        tangled[other[other >= 0]] = True
        if not tangled.any():
            break
        if near is None:  # takes the mean over a vertex and those next to it
            count, ends = len(share), surface.edges
            joined: NDArray[np.int64] = np.concatenate([ends, ends[:, ::-1], np.repeat(np.arange(count)[:, None], 2, axis=1)])
            ones = sp.coo_array((np.ones(len(joined), np.float32), joined.T), shape=(count, count)).tocsr()
            near = sp.diags_array(1.0 / ones.sum(axis=1)) @ ones
        taken = np.zeros(len(relief), np.float32)
        taken[surface.faces[tangled]] = TAKEN
        for _ in range(SPREAD):
            taken = np.maximum(taken, near @ taken)
        share *= 1.0 - taken
    return np.asarray(relief * share, np.float32)
