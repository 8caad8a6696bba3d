"""The Warp kernels of this room."""

# mypy: disable-error-code="attr-defined,no-untyped-def,valid-type"
# Warp reads these annotations itself: they are calls, and its query results are typed by the compiler.

from __future__ import annotations

from mechstyle._warp import wp


@wp.kernel
def nearest_points(
    mesh: wp.uint64, queries: wp.array(dtype=wp.vec3), reach: float, face: wp.array(dtype=wp.int32), uv: wp.array(dtype=wp.vec2)
) -> None:
    """Face and first two barycentric weights of the surface point nearest to each query; face -1 beyond `reach`."""
    i = wp.tid()
    hit = wp.mesh_query_point_no_sign(mesh, queries[i], reach)
    face[i] = -1
    if hit.result:
        face[i] = hit.face
        uv[i] = wp.vec2(hit.u, hit.v)


@wp.kernel
def shrink_balls(
    mesh: wp.uint64, points: wp.array(dtype=wp.vec3), normals: wp.array(dtype=wp.vec3), largest: float, skin: float, cosine: float,
    slack: float, diameter: wp.array(dtype=wp.float32), facing: wp.array(dtype=wp.float32),
) -> None:  # fmt: skip
    """Diameter of the largest inner ball touching each point, shrunk from half the ray to the opposite wall.

    `facing` is the cosine of the angle between both contacts seen from the centre: -1 between parallel walls, 1 if nothing was met.
    """
    i = wp.tid()
    p = points[i]
    inward = -normals[i]
    radius = 0.5 * largest
    cosine_met = wp.float32(1.0)
    ahead = wp.mesh_query_ray(mesh, p + inward * skin, inward, largest)
    if ahead.result:
        radius = 0.5 * (ahead.t + skin)
        cosine_met = -wp.dot(ahead.normal, inward)
    for _step in range(30):
        centre = p + inward * radius
        near = wp.mesh_query_point_no_sign(mesh, centre, slack * radius)
        if not near.result:
            break
        contact = wp.mesh_eval_position(mesh, near.face, near.u, near.v)
        chord = contact - p
        height = wp.dot(chord, inward)
        # A contact seen from the centre close to p is the curvature of this side, not the other wall.
        if height <= 0.0 or wp.dot(p - centre, contact - centre) > cosine * radius * wp.length(contact - centre):
            break
        shrunk = 0.5 * wp.dot(chord, chord) / height
        if shrunk >= radius:
            break
        radius = shrunk
        cosine_met = 1.0 - height / radius
    diameter[i] = 2.0 * radius
    facing[i] = cosine_met


@wp.kernel
def count_escapes(
    mesh: wp.uint64, points: wp.array(dtype=wp.vec3), normals: wp.array(dtype=wp.vec3), rays: wp.array(dtype=wp.vec3), skin: float,
    reach: float, escaped: wp.array(dtype=wp.int32),
) -> None:  # fmt: skip
    """Number of `rays`, given about z and turned to each normal (Duff et al. 2017), that leave without meeting the surface again."""
    i = wp.tid()
    normal = normals[i]
    side = wp.where(normal[2] >= 0.0, 1.0, -1.0)
    a = -1.0 / (side + normal[2])
    b = normal[0] * normal[1] * a
    across = wp.vec3(1.0 + side * normal[0] * normal[0] * a, side * b, -side * normal[0])
    along = wp.vec3(b, side + normal[1] * normal[1] * a, -normal[1])
    count = wp.int32(0)
    for k in range(rays.shape[0]):
        ray = across * rays[k][0] + along * rays[k][1] + normal * rays[k][2]
        if not wp.mesh_query_ray_anyhit(mesh, points[i] + normal * skin, ray, reach):
            count += 1
    escaped[i] = count


@wp.kernel
def count_narrow(
    mesh: wp.uint64, points: wp.array(dtype=wp.vec3), directions: wp.array(dtype=wp.vec3), widest: float, narrow: wp.array(dtype=wp.int32)
) -> None:
    """Number of `directions`, the same for all points, along which what is met both ways is no farther apart than `widest`."""
    i = wp.tid()
    count = wp.int32(0)
    for k in range(directions.shape[0]):
        ahead = wp.mesh_query_ray(mesh, points[i], directions[k], widest)
        if ahead.result:
            behind = wp.mesh_query_ray(mesh, points[i], -directions[k], widest)
            if behind.result and ahead.t + behind.t <= widest:
                count += 1
    narrow[i] = count


@wp.kernel
def gather_light(
    mesh: wp.uint64, points: wp.array(dtype=wp.vec3), normals: wp.array(dtype=wp.vec3), directions: wp.array(dtype=wp.vec3), skin: float,
    reach: float, light: wp.array(dtype=wp.float32),
) -> None:  # fmt: skip
    """Sum of the cosines between each normal and those `directions`, the same for all points, that leave without meeting the surface."""
    i = wp.tid()
    normal = normals[i]
    total = wp.float32(0.0)
    for k in range(directions.shape[0]):
        cosine = wp.dot(normal, directions[k])
        if cosine > 0.0 and not wp.mesh_query_ray_anyhit(mesh, points[i] + normal * skin, directions[k], reach):
            total += cosine
    light[i] = total


@wp.func
def touches(vertex: wp.int32, a: wp.int32, b: wp.int32, c: wp.int32) -> bool:
    """Whether a vertex is one of three."""
    return vertex == a or vertex == b or vertex == c  # noqa: PLR1714 (Warp knows no `in`)


@wp.func
def between(axis: wp.vec3d, p: wp.vec3d, q: wp.vec3d, r: wp.vec3d, d: wp.vec3d, e: wp.vec3d, f: wp.vec3d) -> bool:
    """Whether a plane across an axis lies between two triangles."""
    one, two, three = wp.dot(axis, p), wp.dot(axis, q), wp.dot(axis, r)
    four, five, six = wp.dot(axis, d), wp.dot(axis, e), wp.dot(axis, f)
    below = wp.max(wp.max(one, two), three) < wp.min(wp.min(four, five), six)
    return below or wp.max(wp.max(four, five), six) < wp.min(wp.min(one, two), three)


@wp.func
def beside(p: wp.vec3d, q: wp.vec3d, r: wp.vec3d, d: wp.vec3d, e: wp.vec3d, f: wp.vec3d) -> bool:
    """Whether all of a triangle lies beyond a side of another, seen along its normal.

    In one plane Möller's test is decided by rounding: it finds crossings of triangles that lie apart.
    """
    normal = wp.cross(q - p, r - p)
    return (
        between(wp.cross(normal, q - p), p, q, r, d, e, f)
        or between(wp.cross(normal, r - q), p, q, r, d, e, f)
        or between(wp.cross(normal, p - r), p, q, r, d, e, f)
    )


@wp.kernel
def count_crossings(
    mesh: wp.uint64, faces: wp.array(dtype=wp.int32), points: wp.array(dtype=wp.vec3d), crossed: wp.array(dtype=wp.int32),
    other: wp.array(dtype=wp.int32),
) -> None:  # fmt: skip
    """For each face, how many faces of higher number cross it and share no corner with it; in `other`, the highest face it crosses."""
    i = wp.tid()
    a, b, c = faces[3 * i], faces[3 * i + 1], faces[3 * i + 2]
    p, q, r = points[a], points[b], points[c]
    low, high = wp.min(wp.min(p, q), r), wp.max(wp.max(p, q), r)
    count = wp.int32(0)
    for j in wp.mesh_query_aabb(mesh, wp.vec3(low), wp.vec3(high)):
        if j > i:
            d, e, f = faces[3 * j], faces[3 * j + 1], faces[3 * j + 2]
            joined = touches(d, a, b, c) or touches(e, a, b, c) or touches(f, a, b, c)
            s, t, u = points[d], points[e], points[f]
            apart = joined or beside(p, q, r, s, t, u) or beside(s, t, u, p, q, r)
            if not apart and wp.intersect_tri_tri(p, q, r, s, t, u) == 1:
                count += 1
                wp.atomic_max(other, i, j)
                wp.atomic_max(other, j, i)
    crossed[i] = count


@wp.kernel
def turns_exceed(mesh: wp.uint64, points: wp.array(dtype=wp.vec3), threshold: float, exceeds: wp.array(dtype=wp.bool)) -> None:
    """Whether the surface winds around each point more often than a threshold (Barill et al. 2018)."""
    i = wp.tid()
    query = wp.mesh_query_point_sign_winding_number(mesh, points[i], 1.0e6, 2.0, threshold)
    exceeds[i] = query.sign < 0.0


@wp.func
def neighbours_in_common(
    a: wp.int32, b: wp.int32, faces: wp.array(dtype=wp.vec3i), first: wp.array(dtype=wp.int32), around: wp.array(dtype=wp.int32)
) -> wp.int32:
    """Vertices next to both ends of an edge of a closed surface; 99 if one of them has three neighbours only, and cannot lose one."""
    common = wp.int32(0)
    for at_a in range(first[a], first[a + 1]):
        neighbour = follower(a, faces[around[at_a]])
        for at_b in range(first[b], first[b + 1]):
            if follower(b, faces[around[at_b]]) == neighbour:
                common += 1
                if first[neighbour + 1] - first[neighbour] < 4:
                    common += 99
    return common


@wp.func
def follower(vertex: wp.int32, face: wp.vec3i) -> wp.int32:
    """The corner after a vertex in a face that has it."""
    if face[0] == vertex:
        return face[1]
    if face[1] == vertex:
        return face[2]
    return face[0]


@wp.func
def keeps_its_side(a: wp.vec3d, b: wp.vec3d, c: wp.vec3d, to: wp.vec3d, longest: wp.float64, cosine: wp.float64) -> bool:
    """Whether the triangle abc can move its corner a without turning too far or an edge at it becoming too long."""
    was, becomes = wp.cross(b - a, c - a), wp.cross(b - to, c - to)  # normals as long as twice the areas
    short = wp.length(b - to) <= longest and wp.length(c - to) <= longest
    return short and wp.dot(was, becomes) > cosine * wp.length(was) * wp.length(becomes)


@wp.kernel
def sound_collapses(
    edges: wp.array(dtype=wp.vec2i), meeting: wp.array(dtype=wp.vec3d), vertices: wp.array(dtype=wp.vec3d), faces: wp.array(dtype=wp.vec3i),
    first: wp.array(dtype=wp.int32), around: wp.array(dtype=wp.int32), longest: wp.float64, cosine: wp.float64,
    sound: wp.array(dtype=wp.bool),
) -> None:  # fmt: skip
    """Whether the ends of each edge can meet in one point: the surface stays one, no edge gets too long, no triangle turns too far."""
    i = wp.tid()
    sound[i] = neighbours_in_common(edges[i][0], edges[i][1], faces, first, around) == 2
    for end in range(2):
        vertex = edges[i][end]
        other = edges[i][1 - end]
        for at in range(first[vertex], first[vertex + 1]):
            face = faces[around[at]]
            b = follower(vertex, face)
            c = follower(b, face)
            here = b == other or c == other  # noqa: PLR1714 (Warp knows no tuples); such a face goes
            if not here and not keeps_its_side(vertices[vertex], vertices[b], vertices[c], meeting[i], longest, cosine):
                sound[i] = False
