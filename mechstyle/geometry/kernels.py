"""The Warp kernels of this room, and Warp told to keep quiet."""

# mypy: disable-error-code="attr-defined,no-untyped-def,valid-type"
# Warp reads these annotations itself: they are calls, and its query results are typed by the compiler.

from __future__ import annotations

from mechstyle.quiet import wp


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
    mesh: wp.uint64,
    points: wp.array(dtype=wp.vec3),
    normals: wp.array(dtype=wp.vec3),
    largest: float,
    skin: float,
    cosine: float,
    slack: float,
    diameter: wp.array(dtype=wp.float32),
) -> None:
    """Diameter of the largest inner ball touching each point, shrunk from half the ray to the opposite wall."""
    i = wp.tid()
    p = points[i]
    inward = -normals[i]
    radius = 0.5 * largest
    ahead = wp.mesh_query_ray(mesh, p + inward * skin, inward, largest)
    if ahead.result:
        radius = 0.5 * (ahead.t + skin)
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
    diameter[i] = 2.0 * radius
