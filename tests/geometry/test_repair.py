"""Repair: what is mended is said and gives the right body; what cannot be is refused in one sentence."""

import itertools

import manifold3d
import numpy as np
import pytest
import trimesh

from mechstyle.errors import BadInput, SimulationFailed
from mechstyle.geometry import repair
from mechstyle.geometry.one_body import FEW, SHOWN, repaired
from mechstyle.geometry.pieces import Piece, Thing
from mechstyle.records.mesh import SurfaceMesh

BOX = (10.0, 20.0, 30.0)  # volume 6000 mm³


def box(extents=BOX, at=(0.0, 0.0, 0.0), *, inwards=False):
    mesh = trimesh.creation.box(extents)
    mesh.apply_translation(at)
    return arrays(mesh, inwards=inwards)


def arrays(mesh, *, inwards=False):
    faces = np.asarray(mesh.faces)
    return np.array(mesh.vertices, dtype=float), faces[:, ::-1] if inwards else faces


def ball(subdivisions=3, radius=10.0):
    return arrays(trimesh.creation.icosphere(subdivisions, radius))


def together(*parts):
    starts = np.cumsum([0] + [len(vertices) for vertices, _ in parts[:-1]])
    return np.vstack([part[0] for part in parts]), np.vstack([faces + start for (_, faces), start in zip(parts, starts, strict=True)])


def fixed(part):
    surface, notes = repaired([Thing("", (Piece("", *part),))], "part.stl")
    assert surface.is_closed  # whatever else: what comes out is closed, manifold and faces outwards
    assert surface.volume > 0
    return surface, notes


def refusal(part):
    with pytest.raises(BadInput) as caught:
        repaired([Thing("", (Piece("", *part),))], "part.stl")
    message = str(caught.value)
    assert message.startswith("part.stl ")
    assert "\n" not in message
    return message


# --- a single shell -----------------------------------------------------------------------------------------------


def test_a_good_body_is_left_alone():
    surface, notes = fixed(box())
    assert notes == ()
    assert surface.volume == pytest.approx(6000)
    assert (len(surface.vertices), len(surface.faces)) == (8, 12)


def test_the_same_input_gives_the_same_bytes():
    part = together(ball(), box(at=(6.0, 0.0, 0.0)))
    assert len({fixed(part)[0].digest for _ in range(3)}) == 1


def test_a_triangle_soup_is_welded():
    vertices, faces = box()
    surface, notes = fixed((vertices[faces].reshape(-1, 3), np.arange(36).reshape(-1, 3)))
    assert notes == (), "as every STL is: nothing to tell"
    assert surface.volume == pytest.approx(6000)


def test_unused_vertices_are_no_duplicates():
    vertices, faces = box()
    surface, notes = fixed((np.vstack([vertices, vertices[:3]]), faces))
    assert notes == ()
    assert len(surface.vertices) == 8


def test_inverted_faces_are_turned_outwards():
    surface, notes = fixed(box(inwards=True))
    assert notes == ("turned its faces outwards",)
    assert surface.volume == pytest.approx(6000)


def test_mixed_winding_is_made_consistent():
    vertices, faces = box()
    faces = np.where((np.arange(12) % 3 == 0)[:, None], faces[:, ::-1], faces)
    surface, notes = fixed((vertices, faces))
    assert notes == ("made the winding of its faces consistent",)
    assert surface.volume == pytest.approx(6000)


def test_mixed_winding_keeps_a_cavity_a_cavity():
    vertices, faces = together(box(), box((5.0, 5.0, 5.0), inwards=True))
    faces[[0, 15]] = faces[[0, 15], ::-1]  # one face of the outer shell, one of the inner
    surface, notes = fixed((vertices, faces))
    assert notes == ("made the winding of its faces consistent",)
    assert surface.volume == pytest.approx(6000 - 125)


def test_repeated_faces_are_dropped():
    vertices, faces = box()
    surface, notes = fixed((vertices, np.vstack([faces, faces[:3], np.roll(faces[3:4], 1, axis=1)])))
    assert notes == ("dropped 4 degenerate or repeated faces",)
    assert len(surface.faces) == 12


def test_faces_back_to_back_are_dropped():
    vertices, faces = box()
    surface, notes = fixed((vertices, np.vstack([faces, faces[:1, ::-1]])))
    assert notes == ("dropped 1 face with another back to back",)
    assert surface.volume == pytest.approx(6000)


def test_faces_with_a_vertex_twice_are_dropped():
    vertices, faces = box()
    surface, notes = fixed((vertices, np.vstack([faces, [[0, 0, 1], [2, 2, 2]]])))
    assert notes == ("dropped 2 degenerate or repeated faces",)
    assert len(surface.faces) == 12


def test_vertices_of_dropped_faces_have_no_say():
    """Were the part as long as they say, its holes would be hairlines."""
    vertices, faces = ball()
    far = np.array([(1e6, 0.0, 0.0)])
    surface, notes = fixed((np.vstack([vertices, far]), np.vstack([faces[1:], [[0, 0, len(vertices)]]])))
    assert [note.split(" of ")[0] for note in notes] == ["dropped 1 degenerate or repeated face", "closed 1 hole"]
    assert surface.volume == pytest.approx(4 / 3 * np.pi * 1000, rel=0.01)


def test_faces_without_area_close_the_surface_and_stay():
    vertices, faces = box()
    a, b, c = faces[0]  # a vertex on the edge ab of one of its faces only, and a sliver a-b-middle that fills the crack
    vertices = np.vstack([vertices, (vertices[a] + vertices[b]) / 2])
    surface, notes = fixed((vertices, np.vstack([faces[1:], [[a, 8, c], [8, b, c], [a, b, 8]]])))
    assert notes == ()
    assert surface.volume == pytest.approx(6000)


def test_hairline_gaps_are_closed():
    vertices, faces = box()
    soup = vertices[faces].reshape(-1, 3) + np.random.default_rng(0).uniform(-1e-4, 1e-4, (36, 3))
    surface, notes = fixed((soup, np.arange(36).reshape(-1, 3)))
    assert notes == ("closed hairline gaps between its faces",)
    assert len(surface.vertices) == 8
    assert surface.volume == pytest.approx(6000, abs=2200 * 1e-4)  # the surface times how far it moved


def test_wider_gaps_are_no_hairlines():
    vertices, faces = box()
    triangles = vertices[faces]
    apart = (triangles + 0.5 * np.sign(triangles.mean(axis=1, keepdims=True))).reshape(-1, 3)
    assert "is open and cannot be closed" in refusal((apart, np.arange(36).reshape(-1, 3)))


@pytest.mark.parametrize("missing", [1, 4])
def test_a_small_hole_is_closed(missing):
    vertices, faces = ball()
    whole = fixed((vertices, faces))[0]
    surface, notes = fixed((vertices, faces[missing:]))
    area = whole.face_areas.sum() / len(faces) * missing
    assert len(notes) == 1
    assert notes[0].startswith("closed 1 hole of ")
    assert float(notes[0].split()[4]) == pytest.approx(area, rel=0.2)  # the triangles of an icosphere differ by that much
    assert surface.volume == pytest.approx(whole.volume, abs=area * 0.3)  # the hole times the height of the cap that is gone


def test_holes_of_one_part_are_closed_together():
    vertices, faces = ball()
    far = vertices[faces].mean(axis=1)[:, 2]
    surface, notes = fixed((vertices, faces[(far > far.min()) & (far < far.max())]))
    assert [note.split(" of ")[0] for note in notes] == ["closed 2 holes"]
    assert surface.volume == pytest.approx(4 / 3 * np.pi * 1000, rel=0.01)


@pytest.mark.parametrize("sections", [16, 256])
def test_a_tube_without_ends_is_refused_however_fine_its_triangles(sections):
    """Filled, it would be a rod."""
    tube = trimesh.creation.cylinder(5.0, 20.0, sections=sections)
    for _ in range(2):
        tube = tube.subdivide()
    message = refusal((tube.vertices, tube.faces[np.abs(tube.face_normals[:, 2]) < 0.5]))
    assert "is open and cannot be closed: an opening of 7" in message  # 25π = 78.5 mm²
    assert "give it a thickness or cap the opening" in message


def test_what_is_open_is_no_manifold_and_manifold_is_not_asked(monkeypatch):
    """Its constructor crashed the process at two closed boxes and a loose triangle, three times of four."""
    vertices, faces = together(box(), box(at=(20.0, 0.0, 0.0)))
    loose = np.vstack([faces, [[0, 9, 3]]])
    monkeypatch.setattr(repair, "manifold_of", lambda _: pytest.fail("it was asked"))
    assert repair._accepted(SurfaceMesh(vertices, loose)) is None


def test_a_missing_side_is_refused():
    vertices, faces = box()
    top = (vertices[faces][:, :, 2] == 15).all(axis=1)
    assert "an opening of 200 mm² is no small hole in a surface of 2000 mm²" in refusal((vertices, faces[~top]))


@pytest.mark.parametrize("sides", [1, 2])
@pytest.mark.parametrize("tilted", [False, True])
def test_a_flat_sheet_is_refused(sides, tilted):
    vertices = np.array([(0, 0, 0), (10, 0, 0), (10, 10, 0), (0, 10, 0)], dtype=float)
    if tilted:
        vertices = vertices @ np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    faces = np.array([(0, 1, 2), (0, 2, 3), (2, 1, 0), (3, 2, 0)])[: 2 * sides]
    assert "is flat and encloses no volume: give it a thickness" in refusal((vertices, faces))


def test_a_box_without_height_is_refused():
    assert "is flat and encloses no volume" in refusal(box((10.0, 20.0, 0.0)))


def test_a_bent_sheet_without_thickness_is_refused():
    """Closed and not flat, but with a thousandth of a millimetre between its sides."""
    outside = np.array([(0, 0, 0), (10, 0, 0), (0, 10, 0), (0, 0, 10)], dtype=float)
    triangles = np.array([(0, 1, 2), (0, 2, 3)])
    rim = [triangle for a, b in ((0, 1), (1, 2), (2, 3), (3, 0)) for triangle in ((b, a, a + 4), (b, a + 4, b + 4))]
    message = refusal((np.vstack([outside, outside + 1e-3]), np.vstack([triangles, triangles[:, ::-1] + 4, rim])))
    assert "encloses no volume: give it a thickness" in message


def test_nothing_but_degenerate_faces_is_refused():
    assert "holds no triangle with an area" in refusal((np.eye(3), np.array([(0, 0, 1), (2, 2, 2)])))


def test_a_body_that_cuts_through_itself_is_left_as_it_is_and_said():
    """It is closed, so nothing has to be mended; the tetrahedra made from it take the inside by winding number."""
    vertices, faces = ball()
    vertices[vertices[:, 2] > 8, 2] -= 25  # the top pushed out through the bottom
    surface, notes = fixed((vertices, faces))
    (note,) = notes
    assert note.startswith("its surface passes through itself in 1 place, around (")
    assert len(surface.faces) == len(faces)


# --- several shells -----------------------------------------------------------------------------------------------


def test_overlapping_bodies_are_united():
    surface, notes = fixed(together(box(), box(at=(5.0, 0.0, 0.0))))
    assert notes == ("united 2 overlapping bodies",)
    assert surface.volume == pytest.approx(15 * 20 * 30)


def test_a_body_inside_out_among_others_is_turned():
    surface, notes = fixed(together(box(), box(at=(5.0, 0.0, 0.0), inwards=True)))
    assert notes == ("turned 1 body outwards", "united 2 overlapping bodies")
    assert surface.volume == pytest.approx(15 * 20 * 30)


def test_a_small_body_inside_out_is_no_cavity_where_it_sticks_out():
    surface, _ = fixed(together(box(), box((4.0, 4.0, 4.0), at=(5.0, 0.0, 0.0), inwards=True)))
    assert surface.volume == pytest.approx(6000 + 2 * 16)


def test_a_cavity_is_kept():
    surface, notes = fixed(together(box(), box((5.0, 5.0, 5.0), inwards=True)))
    assert notes == ()
    assert surface.volume == pytest.approx(6000 - 125)
    assert len(surface.faces) == 24


def test_a_hollow_body_inside_out_is_turned_as_a_whole():
    surface, notes = fixed(together(box(inwards=True), box((5.0, 5.0, 5.0))))
    assert notes == ("turned its faces outwards",)
    assert surface.volume == pytest.approx(6000 - 125)


def test_a_body_fills_the_part_of_the_cavity_of_another_that_it_reaches():
    surface, _ = fixed(together(box(), box((5.0, 5.0, 5.0), inwards=True), box(at=(5.0, 0.0, 0.0))))
    assert surface.volume == pytest.approx(15 * 20 * 30 - 125 / 2)


def test_a_body_within_another_is_taken_for_material():
    surface, notes = fixed(together(box(), box((5.0, 5.0, 5.0))))
    assert notes == ("united 2 overlapping bodies",)
    assert surface.volume == pytest.approx(6000)


def sheet(side, at):
    """A square of no thickness, parallel to the floor."""
    corners = 0.5 * side * np.array([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]) + at
    return corners, np.array([(0, 1, 2), (0, 2, 3)])


def test_a_loose_sheet_within_a_body_is_dropped_and_said():
    """It was called an opening of the body around it, which is closed."""
    surface, notes = fixed(together(box(), sheet(8.0, (0.0, 0.0, 0.0)), sheet(8.0, (0.0, 0.0, 3.0))))
    assert notes == ("dropped 2 sheets without thickness inside it",)
    assert surface.volume == pytest.approx(6000)


def test_many_loose_sheets_are_looked_for_once(monkeypatch):
    """Rays were cast again for every sheet: a figure of 72 000 faces with 13 000 loose triangles was not read in two minutes."""
    cast, real = [], repair.escaping
    monkeypatch.setattr(repair, "escaping", lambda *given: cast.append(len(given[1])) or real(*given))
    sheets = [sheet(2.0, (0.0, 0.0, 0.5 * at)) for at in range(-20, 21)]
    surface, notes = fixed(together(box(), *sheets))
    assert notes == ("dropped 41 sheets without thickness inside it",)
    assert surface.volume == pytest.approx(6000)
    assert cast == [2 * 4 * len(sheets)] * 2, "for both sides, at four places of two faces"


def test_a_large_piece_with_holes_that_is_seen_is_not_looked_at_all_over(monkeypatch):
    """Scans have holes: rays from each of a hundred thousand faces took minutes."""
    looked_at, real = [], repair.escaping
    monkeypatch.setattr(repair, "escaping", lambda tree, points, *others: looked_at.append(len(points)) or real(tree, points, *others))
    ball = trimesh.creation.icosphere(4, 30.0)
    pierced = SurfaceMesh(ball.vertices, ball.faces[1:])
    count = len(pierced.faces)
    assert repair._inner(pierced, np.zeros(count, np.int32), *repair._edges_of(pierced)) == set()
    assert sum(looked_at) < 0.3 * count


@pytest.mark.parametrize("at", [(0.0, 0.0, 30.0), (5.0, 0.0, 0.0)], ids=["outside", "through a side"])
def test_a_sheet_that_is_not_within_the_body_is_refused(at):
    assert "is open and cannot be closed" in refusal(together(box(), sheet(8.0, at)))


def wall(low, high):
    """An upright square of no thickness, from one corner of the floor to another."""
    (x, y), (u, v) = low, high
    return np.array([(x, y, -15.0), (u, v, -15.0), (u, v, 15.0), (x, y, 15.0)]), np.array([(0, 1, 2), (0, 2, 3)])


def cut_box(*, hollow=False):
    """A box of 10 x 20 x 30 mm of which every side has vertices and edges where y is 0, and so may have a cavity."""
    halves = [box((10.0, 10.0, 30.0), at=(0.0, y, 0.0)) for y in (-5.0, 5.0)]
    vertices, faces = together(*halves)
    whole = vertices, faces[~(np.abs(vertices[faces][:, :, 1]) < 1e-9).all(axis=1)]
    if not hollow:
        return whole
    inner = whole[0] * (0.6, 0.6, 0.6), whole[1][:, ::-1]
    return together(whole, inner)


HALVES = wall((-5.0, 0.0), (0.0, 0.0)), wall((0.0, 0.0), (5.0, 0.0))
CROSSING = wall((0.0, -10.0), (0.0, 0.0)), wall((0.0, 0.0), (0.0, 10.0))
ACROSS = wall((-3.0, 0.0), (3.0, 0.0))


@pytest.mark.parametrize(
    ("part", "volume", "count"),
    [
        (together(box(), wall((0.0, -10.0), (0.0, 10.0))), 6000, 1),
        (together(cut_box(), wall((-5.0, 0.0), (5.0, 0.0))), 6000, 1),
        (together(cut_box(), wall((5.0, 0.0), (-5.0, 0.0))), 6000, 1),
        (together(cut_box(), *HALVES), 6000, 1),
        (together(box(), *HALVES, *CROSSING), 6000, 4),
        (together(cut_box(hollow=True), (ACROSS[0] * (1.0, 1.0, 0.6), ACROSS[1])), 6000 * (1 - 0.6**3), 1),
    ],
    ids=["not welded", "welded", "the other way round", "in two", "two that cross", "across a cavity"],
)
def test_walls_without_thickness_inside_are_dropped_and_said(part, volume, count):
    """As SketchUp leaves them; the part was called open, though its outside is closed."""
    surface, notes = fixed(part)
    assert f"dropped {count} sheet{'s' if count > 1 else ''} without thickness inside it" in notes
    assert surface.volume == pytest.approx(volume)


def test_a_fin_without_thickness_outside_is_no_wall_inside():
    assert "is open and cannot be closed" in refusal(together(cut_box(), wall((5.0, 0.0), (25.0, 0.0))))


def test_a_loose_body_in_a_cavity_is_refused():
    rattle = together(box(), box((8.0, 8.0, 8.0), inwards=True), box((5.0, 5.0, 5.0)))
    assert "holds 2 separate bodies" in refusal(rattle)


@pytest.mark.parametrize("flipped_diagonals", [False, True])
def test_touching_cubes_are_one_body(flipped_diagonals):
    left, right = box((10.0, 10.0, 10.0)), box((10.0, 10.0, 10.0), at=(10.0, 0.0, 0.0))
    if flipped_diagonals:  # mirrored, so that the shared side has the same triangles from both sides, back to back
        right = left[0] * (-1, 1, 1) + (10, 0, 0), left[1][:, ::-1]
    surface, _ = fixed(together(left, right))
    assert surface.volume == pytest.approx(2000)
    assert surface.face_areas.sum() == pytest.approx(1000)  # nothing is left of the wall between them


def test_bodies_that_share_an_edge_only_are_separate():
    message = refusal(together(box(), box((10.0, 20.0, 25.0), at=(10.0, 20.0, 0.0))))
    assert "holds 2 separate bodies, 1 (10 × 20 × 30 mm), 2 (10 × 20 × 25 mm): a drop test needs one" in message


def test_separate_bodies_are_refused_with_their_sizes_in_the_order_of_the_file():
    message = refusal(together(box((5.0, 6.0, 7.0), at=(40.0, 0.0, 0.0)), box()))
    assert "holds 2 separate bodies, 1 (5 × 6 × 7 mm), 2 (10 × 20 × 30 mm): a drop test needs one; choose it with --body 1" in message


def test_of_many_separate_bodies_few_are_named():
    message = refusal(together(*(box((5.0, 5.0, 5.0 + k), at=(10.0 * k, 0.0, 0.0)) for k in range(9))))
    assert "holds 9 separate bodies, 1 (5 × 5 × 5 mm), " in message
    assert message.count("(5 × 5 × ") == SHOWN
    assert "and 3 more" in message


@pytest.mark.parametrize("inwards", [False, True])
def test_specks_are_left_out_with_their_size_and_place(inwards):
    surface, notes = fixed(together(box(), box((0.5, 0.5, 0.5), at=(40.0, 0.0, 0.0), inwards=inwards)))
    assert notes[-1] == "left out 1 speck apart from the part: 0.5 × 0.5 × 0.5 mm at (40.0, 0.0, 0.0)"
    assert surface.extents == pytest.approx(BOX)
    assert surface.volume == pytest.approx(6000)


def test_dust_that_no_printer_shows_is_left_out_however_much_there_is():
    """Crumbs of a scan, of a tenth of a millimetre each, were listed as bodies to choose from."""
    crumbs = [box((0.1, 0.1, 0.1), at=(20.0 + k, 0.0, 0.0)) for k in range(FEW + 2)]
    assert f"left out {FEW + 2} specks apart from the part" in fixed(together(box(), *crumbs))[1][-1]


@pytest.mark.parametrize(
    ("size", "count"), [((0.5, 0.5, 2.0), 1), ((0.5, 0.5, 0.5), FEW + 1)], ids=["longer than a speck", "more than few"]
)
def test_what_may_say_something_is_no_speck(size, count):
    assert "separate bodies" in refusal(together(box(), *(box(size, at=(20.0 + 5 * k, 0.0, 0.0)) for k in range(count))))


@pytest.mark.parametrize("gap", [-0.1, 0.0, 1e-4])
def test_small_bodies_that_overlap_or_touch_the_part_are_part_of_it(gap):
    """Dots of 0.5 mm on a plate, as shells of their own: of Braille, of an i, of a stud; once they were specks."""
    dots = [box((0.5, 0.5, 0.5), at=(x, y, 15.25 + gap)) for x in (-3.0, 0.0, 3.0) for y in (-8.0, -4.0, 0.0, 4.0, 8.0)]
    surface, notes = fixed(together(box(), *dots))
    assert "united 16 overlapping bodies" in notes
    assert surface.volume == pytest.approx(6000 + 15 * 0.25 * (0.5 + min(gap, 0.0)), abs=0.02)


def test_a_body_that_touches_another_one_within_a_hairline_on_a_slant_is_united():
    solid = manifold3d.Manifold.cube((20, 20, 20), True), manifold3d.Manifold.cube((4, 4, 4), True).translate((12.00001, 0, 0))
    turned = [(mesh.vert_properties, mesh.tri_verts.astype(int)) for mesh in (one.rotate((30, 20, 10)).to_mesh64() for one in solid)]
    assert fixed(together(*turned))[0].volume == pytest.approx(8064, rel=1e-4)


def test_specks_do_not_cost_the_cavity():
    speck = box((0.5, 0.5, 0.5), at=(40.0, 0.0, 0.0))
    surface, _ = fixed(together(box(), box((5.0, 5.0, 5.0), inwards=True), speck))
    assert surface.volume == pytest.approx(6000 - 125)


def test_a_part_made_by_boolean_operations_passes_unchanged():
    made = manifold3d.Manifold.cube(BOX, True) - manifold3d.Manifold.cylinder(40, 3, 3, 64, True)
    mesh = made.to_mesh64()
    surface, notes = fixed((mesh.vert_properties, mesh.tri_verts.astype(int)))
    assert notes == ()
    assert surface.volume == pytest.approx(made.volume())


# --- the last resort ----------------------------------------------------------------------------------------------


def finned():
    """A box with a triangle of 1 mm² standing on one of its edges, which three faces then share."""
    vertices, faces = box()
    a, b = faces[0][:2]
    out = vertices[[a, b]].mean(axis=0)
    out = out + 2 / np.linalg.norm(vertices[a] - vertices[b]) * out / np.linalg.norm(out)
    return np.vstack([vertices, out]), np.vstack([faces, [a, b, 8]])


def test_an_edge_of_three_faces_needs_the_last_resort(monkeypatch):
    def answer(vertices, faces, settings, *, timeout):
        tets = np.array([(0, 1, 2, 3), (1, 3, 2, 4)])[:, ::-1]  # of any orientation
        return 10.0 * np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1)], dtype=float), tets.astype(np.int32)

    monkeypatch.setattr(repair, "tetwild", answer)
    surface, notes = fixed(finned())
    assert notes[-1].startswith("rebuilt its surface from the volume inside it")
    assert surface.volume == pytest.approx(1000 / 6 + 1000 / 3)
    assert len(surface.faces) == 6


def test_a_crack_is_no_hole(monkeypatch):
    """One loop of gaps along three edges at right angles: a fan over it would fold over the sides of the box."""
    vertices, faces = box()
    corner_path = [0, 1, 3, 7]  # neighbours by one coordinate each
    for a, b in itertools.pairwise(corner_path):
        side = np.flatnonzero([{a, b} <= set(face) for face in faces])[0]
        middle = vertices[[a, b]].mean(axis=0) * 0.99
        new = len(vertices)
        vertices = np.vstack([vertices, middle])
        halves = [np.where(faces[side] == old, new, faces[side]) for old in (a, b)]
        faces = np.vstack([np.delete(faces, side, axis=0), halves])
    asked = []

    def answer(vertices, faces, settings, *, timeout):
        asked.append(len(faces))
        raise SimulationFailed("no answer")

    monkeypatch.setattr(repair, "tetwild", answer)
    refusal((vertices, faces))
    assert asked == [15]  # twelve and the three halves, and not one of a fan


def test_a_last_resort_that_fails_is_a_refusal(monkeypatch):
    def answer(*_, timeout):
        raise SimulationFailed("fTetWild found nothing inside the surface")

    monkeypatch.setattr(repair, "tetwild", answer)
    message = refusal(finned())
    assert "could not be repaired (fTetWild found nothing inside the surface); repair it in the program" in message


@pytest.mark.slow
def test_the_last_resort_gives_the_body_without_its_fin():
    surface, notes = fixed(finned())
    assert notes[-1].startswith("rebuilt its surface from the volume inside it")
    assert surface.volume == pytest.approx(6000, rel=0.01)  # its envelope is 5e-4 of the diagonal: 0.02 mm of 2200 mm²
