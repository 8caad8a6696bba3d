"""Every tolerance of the chapter, with what it is measured in and why it is as large as it is."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Tolerances:
    """Tolerances, thresholds and numbers of rounds of remeshing; a change of one changes results, so that caches need a new version."""

    # Evening: what is fixed, and when the count fits. Lengths in edge lengths, unless another unit is given.
    crease: float = math.radians(30.0)  # an edge where the surface turns by more is a crease
    bend: float = math.radians(2.0)  # one where it turns by less says nothing of a round
    finest_step: float = 0.45  # between the vertices that are fixed on narrow rounds, at least …
    widest_step: float = 0.8  # … and at most
    row: float = 0.05  # vertices of a round whose distances from its border differ by less are in one row
    next_in_row: float = 1.6  # steps within which the next one of a row is looked for
    clearance: float = 0.7  # of such a step, to the nearest crease
    on_the_part: float = 1e-4  # [mm]; what is nearer stays exactly where it is, as on a plane or a crease
    simplified: float = 0.01  # most by which needless vertices may move the surface when they go
    lowest: float = 1e-3  # height below which a triangle is taken out
    no_area: float = 1e-5  # the same, below which none is left
    crowded: float = 0.75  # of the vertices wished for: with so many on creases alone, hardly any are left for what lies between them
    flat_reach: float = 2.0  # what an edge may then grow to where the surface is flat
    missed: float = 0.05  # of the vertices wished for that the count may miss; twice that where it jumps by a whole row around a round
    trials: int = 9  # edge lengths that are tried
    trial_iterations: int = 3  # of the remesher in the first trial: few suffice to see the count
    iterations: int = 8  # … and in the others

    # Isotropic remeshing. Lengths in edge lengths; turns are cosines of the angle by which a triangle's normal may turn.
    long: float = 4.0 / 3.0  # what is longer is split
    short: float = 4.0 / 5.0  # what is shorter collapses
    splits: int = 4  # rounds in an iteration; what is left over waits for the next
    collapses: int = 30
    flips: int = 6
    few: float = 1e-3  # of the vertices: changes in a round after which there is no further one
    turn: float = 0.7  # in a flip or when smoothed
    turn_in_collapse: float = 0.9  # which would round off what is bent within a few triangles
    facing: float = 0.3  # between a vertex and the place on the part it is put down on: another side of a thin wall looks elsewhere
    bent: float = 0.985  # about 10°: an edge between fixed vertices where the surface turns by more has to stay
    flipped_quality: float = 0.3  # quality 4 √3 A / Σ l² that an edge flip must leave
    length_classes: int = 4  # where all lengths differ few edges are the shortest far around, with none the long ones go too
    put_back: int = 4  # times that vertices go back because triangles would turn over

    # Decimation
    cheap: float = 0.06  # of the edges take part in a round: the others wait to be the cheapest
    cheap_at_first: float = 0.3  # the same as long as there are …
    at_first: float = 2.0  # … so many times the triangles wished for
    turn_in_decimation: float = 0.2  # cosine of the angle by which a triangle may turn
    tied: float = 1e-4  # of a quadric's weight, with which a vertex stays in the middle of its edge where planes leave it free
    decimation_rounds: int = 400

    # Cleaning: triangles without area
    degenerate_passes: int = 20
    turn_by_low_ones: float = 0.5  # cosine of a sound triangle's turn when a corner of it moves by less than the height
    turn_by_others: float = 0.999  # the same when it moves further, as it may along a straight crease or in a plane

    # Cleaning: flaps, slivers and notches
    sliver_passes: int = 3
    turnings: int = 12  # rounds of turning edges in a pass
    astray: float = 0.5  # cosine of the angle to the part's normal, below which a triangle is folded over
    straight: float = 0.9  # the same, above which a triangle lies as well as it can
    sliver: float = 0.15  # quality 4 √3 A / Σ l², 1 for an equilateral triangle, below which a triangle is a sliver
    least_gain: float = 1e-3  # of what turning an edge should raise
    notch: float = 0.04  # of its length, by which the middle of an edge that lies across a round misses the part
    notch_weight: float = 2.0  # of that share next to normals and shape: notches are seen from far, and slivers are not
    notch_undoings: int = 6  # rounds of leaving edges as they are where turning them made walls cross

    # Crossings
    deep: float = 0.1  # [mm]; parts of a body that reach less far into each other are no overlap: printers do not resolve it
    grazing: float = 0.05  # |n + m|² / 2 of faces that look at each other within 18°; bodies deep in each other cross more steeply
    one_place: float = 0.05  # of the part's size: overlaps closer than that are one place
    crossings_asked: int = 2000  # evenly chosen, so that a file full of crossings takes no more time

    # Filling. Lengths in walls, a wall being 2 V / A: what a part is thick on average.
    runs: int = 3  # of fTetWild, at most
    least_count: float = 0.6  # of the tetrahedra wished for, that are accepted …
    most_count: float = 1.6  # … and at most
    per_face: float = 0.5  # tetrahedra that an even triangle of the input makes …
    per_kept_face: float = 0.75  # … and one that is kept as it is
    pinched: float = 1e-3  # of the boundary's edges, at which it may touch itself
    loose: float = 0.08  # the input may leave the surface by this (99.9th percentile) …
    envelope: float = 0.04  # … and fTetWild's boundary its input by this …
    widest_envelope: float = 6e-4  # … or by this share of the diagonal, and improvement that
    lost_detail: float = 0.3  # together they may lose no detail larger than this, the input half of it
    needless: float = 0.1  # of such a detail, or of how far they may, by which the surface may move where vertices go before any are chosen
    standing_out: float = 4.0  # [mm²] of the surface, above which kept triangles may not stand out further than they may
    finest_input: int = 8_000  # faces, about: as many as make about as many tetrahedra as are asked for of a part
    low_input: float = 0.2  # of an even triangle's edge: lower ones make slivers, which cost steps, and carry no relief
    exaggeration: tuple[float, ...] = (1.0, 0.3, 0.0)  # shares of the exaggeration wished for, at which triangles are chosen to be kept
    set_down: float = 0.05  # [mm] above the floor within which a vertex on a flat base is set down onto it

    # Improvement. Lengths in reaches: how far a boundary vertex may move in a pass.
    reaches: tuple[float, ...] = (1.0, 0.5)  # of a vertex, pass by pass: after the first pass others are the lowest
    made_higher: float = 0.03  # share of the tetrahedra
    outwards: float = 0.05  # at which a vertex that slides along a bent surface or over an edge stands out
    inside: float = 5.0  # for a vertex inside, which no surface asks to stay
    minimiser_rounds: int = 150  # in a pass: it has converged, or wins no more than rounding does
    peelings: int = 10  # rounds of peeling: a flat tetrahedron may lie under another one
    leaning: float = 0.5  # cosine between two faces up to which peeling would cut an edge of the part off, or a crack into it
    turned_over: float = 1e3  # value of a mesh with a tetrahedron without volume; values are logarithms of a height over another one
    power: float = 2.0  # of Σ 1/h² in the mean that is made small: the higher, the more the very lowest count


TOL = Tolerances()
"""The tolerances in use."""
