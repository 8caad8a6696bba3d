"""A drop as kernels that Warp can differentiate, for `gradient`: every step writes arrays of its own; the law is that of the drop test.

One kernel serves both elements, straight from the table of their shape functions. Shape is taken in float64, so that the finite
differences it is checked against are not rounding; motion is float32 as in the drop test.
"""


# mypy: ignore-errors
# The body of a kernel is Warp's language, which Warp's own compiler checks.

from mechstyle._warp import wp
from mechstyle.fea.backends.kernels import after_contact
from mechstyle.fea.backends.laws import first_piola, von_mises_squared

wp.set_module_options({"enable_backward": True})


@wp.kernel
def shape(
    connectivity: wp.array2d(dtype=int),
    positions: wp.array(dtype=wp.vec3d),
    density: wp.float64,
    heavier: wp.array(dtype=wp.float64),
    mass_shares: wp.array(dtype=wp.float64),
    gradients: wp.array(dtype=wp.mat33f),
    volumes: wp.array(dtype=wp.float64),
    masses: wp.array(dtype=float),
):
    """∇L_1 to ∇L_3 as rows [1/mm], volumes [mm³] and lumped masses [g], scaled, from the corners [mm] and the density [g/mm³]."""
    e = wp.tid()
    x0 = positions[connectivity[e, 0]]
    x1 = positions[connectivity[e, 1]]
    x2 = positions[connectivity[e, 2]]
    x3 = positions[connectivity[e, 3]]
    edges = wp.matrix_from_cols(x1 - x0, x2 - x0, x3 - x0)
    volume = wp.determinant(edges) / wp.float64(6.0)
    gradients[e] = wp.mat33f(wp.inverse(edges))
    volumes[e] = volume
    for a in range(connectivity.shape[1]):
        wp.atomic_add(masses, connectivity[e, a], float(density * volume * mass_shares[a] * heavier[connectivity[e, a]]))


@wp.kernel
def heights_above_floor(
    ends: wp.array2d(dtype=int),
    positions: wp.array(dtype=wp.vec3d),
    normal: wp.vec3d,
    lowest: int,
    heights: wp.array(dtype=float),
):
    """Heights of the nodes above the lowest corner [mm]; a node lies halfway between its `ends`, a corner between itself and itself."""
    i = wp.tid()
    node = wp.float64(0.5) * (positions[ends[i, 0]] + positions[ends[i, 1]])
    heights[i] = float(wp.dot(normal, node - positions[lowest]))


@wp.func
def displacement_gradient(
    connectivity: wp.array2d(dtype=int),
    derivatives: wp.array2d(dtype=wp.vec3f),
    u: wp.array(dtype=wp.vec3f),
    v: wp.array(dtype=wp.vec3f),
    beta: float,
    G: wp.mat33f,
    e: int,
    q: int,
):
    """H = Σ_a (u_a + β v_a) ∇N_aᵀ. A function of its own: on the way back Warp replays functions, but not loops of unknown length."""
    first = u[connectivity[e, 0]] + beta * v[connectivity[e, 0]]  # no gradient sees it; without it H would be a difference of large numbers
    H = wp.mat33f()
    for a in range(connectivity.shape[1]):
        node = connectivity[e, a]
        H += wp.outer(u[node] + beta * v[node] - first, wp.transpose(G) * derivatives[q, a])
    return H


@wp.kernel
def element_forces(
    connectivity: wp.array2d(dtype=int),
    derivatives: wp.array2d(dtype=wp.vec3f),
    gradients: wp.array(dtype=wp.mat33f),
    volumes: wp.array(dtype=wp.float64),
    damping: wp.array(dtype=float),
    u: wp.array(dtype=wp.vec3f),
    v: wp.array(dtype=wp.vec3f),
    law: int,
    mu: float,
    la: float,
    record: int,
    unit: float,
    exponent: wp.float64,
    forces: wp.array(dtype=wp.vec3f),
    powers: wp.array2d(dtype=wp.float64),
):
    """Add −V P ∇N to the nodal forces [N] and, in a recorded step, (σ_vM/unit)^exponent to `powers`, at one Gauss point.

    ∇N_a = Gᵀ d_a with d_a = (∂N_a/∂L_i − ∂N_a/∂L_0), i = 1 to 3, in `derivatives`.
    """
    e, q = wp.tid()
    G = gradients[e]
    H = displacement_gradient(connectivity, derivatives, u, v, damping[e], G, e, q)
    P = first_piola(H, mu, la, law)
    share = float(volumes[e]) / float(derivatives.shape[0])
    for a in range(connectivity.shape[1]):
        wp.atomic_add(forces, connectivity[e, a], -share * (P * (wp.transpose(G) * derivatives[q, a])))
    if record == 1:
        ratio = von_mises_squared(H, P) / (unit * unit)
        wp.atomic_add(powers, e, q, wp.pow(wp.float64(ratio), wp.float64(0.5) * exponent))


@wp.kernel
def advance(
    forces: wp.array(dtype=wp.vec3f),
    masses: wp.array(dtype=float),
    heights: wp.array(dtype=float),
    normal: wp.vec3f,
    dt: float,
    gravity: float,
    friction: float,
    u: wp.array(dtype=wp.vec3f),
    v: wp.array(dtype=wp.vec3f),
    next_u: wp.array(dtype=wp.vec3f),
    next_v: wp.array(dtype=wp.vec3f),
):
    """`kernels.advance` for one node, without the sums of the history."""
    i = wp.tid()
    free = v[i] + dt * (forces[i] / masses[i] - gravity * normal)
    gap = heights[i] + wp.dot(normal, u[i] + dt * free)
    velocity = free
    if gap < 0.0:
        velocity = after_contact(free, gap, normal, dt, friction)
    next_u[i] = u[i] + dt * velocity
    next_v[i] = velocity
