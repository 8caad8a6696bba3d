"""One step of the drop test as Warp kernels, float32, for any device; the formulas are those of `elasticity`.

Layout: [node][orientation] and [tetrahedron][orientation], orientation fastest, so that neighbouring threads of a GPU touch
neighbouring memory. The element kernels write each tetrahedron's nodal forces to slots of its own, sorted by node; the node kernel
adds up its slots, which follow each other. There are no atomic sums, so the same inputs give the same bytes.
"""

from mechstyle._warp import wp
from mechstyle.fea.backends.laws import stress_at
from mechstyle.fea.elements import GAUSS_A, GAUSS_B

wp.set_module_options({"enable_backward": False})

NEAR, FAR = wp.constant(4.0 * GAUSS_A), wp.constant(4.0 * GAUSS_B)
"""4 L at a Gauss point of the quadratic element for its near corner and for the others: ∂N_ij/∂L_i = 4 L_j."""


Nodes4 = wp.types.matrix(shape=(4, 3), dtype=float)
Nodes10 = wp.types.matrix(shape=(10, 3), dtype=float)
Between = wp.types.matrix(shape=(4, 4), dtype=int)

BETWEEN = wp.constant(Between(0, 4, 5, 6, 4, 1, 7, 8, 5, 7, 2, 9, 6, 8, 9, 3))
"""Node between two corners of a quadratic element, the corner itself on the diagonal; see `elements.EDGES`."""


@wp.func
def plus_linear(H: wp.mat33f, x0: wp.vec3f, x1: wp.vec3f, x2: wp.vec3f, x3: wp.vec3f, G: wp.mat33f):
    """H and the gradient of the linear field with the values x_0 to x_3 at the corners; rows of G are ∇L_1 to ∇L_3."""
    return H + wp.matrix_from_cols(x1 - x0, x2 - x0, x3 - x0) * G


@wp.func
def linear_gradient(field: wp.array2d(dtype=wp.vec3f), nodes: wp.array2d(dtype=int), G: wp.mat33f, e: int, b: int):
    """∇ of a nodal field in a linear element."""
    return plus_linear(wp.mat33f(), field[nodes[e, 0], b], field[nodes[e, 1], b], field[nodes[e, 2], b], field[nodes[e, 3], b], G)


@wp.func
def nodal_values(field: wp.array2d(dtype=wp.vec3f), nodes: wp.array2d(dtype=int), e: int, b: int):
    """A nodal field in a quadratic element, less its value at corner 0, which no gradient sees."""
    x = Nodes10()
    first = field[nodes[e, 0], b]
    for a in range(10):
        x[a] = field[nodes[e, a], b] - first
    return x


@wp.func
def values_ahead(u: wp.array2d(dtype=wp.vec3f), v: wp.array2d(dtype=wp.vec3f), beta: float, nodes: wp.array2d(dtype=int), e: int, b: int):
    """The nodal field u + β v in a quadratic element, less its value at corner 0."""
    x = Nodes10()
    first = u[nodes[e, 0], b] + beta * v[nodes[e, 0], b]
    for a in range(10):
        x[a] = u[nodes[e, a], b] + beta * v[nodes[e, a], b] - first
    return x


@wp.func
def common_gradient(x: Nodes10, G: wp.mat33f):
    """The part of the displacement gradient that is the same at the four Gauss points of a quadratic element."""
    base = Nodes4()
    for i in range(4):
        edges = wp.vec3f()
        for j in range(4):
            if i != j:
                edges += x[BETWEEN[i, j]]
        base[i] = (FAR - 1.0) * x[i] + FAR * edges
    return plus_linear(wp.mat33f(), base[0], base[1], base[2], base[3], G)


@wp.func
def quadratic_gradient(common: wp.mat33f, x: Nodes10, G: wp.mat33f, q: int):
    """∇ at Gauss point q of a quadratic element."""
    extra = (NEAR - FAR) * G
    return plus_linear(common, x[BETWEEN[0, q]], x[BETWEEN[1, q]], x[BETWEEN[2, q]], x[BETWEEN[3, q]], extra)


@wp.func
def corner_forces(P: wp.mat33f, G: wp.mat33f, volume: float):
    """−V P ∇L_i for the four corners as rows [N]."""
    F = wp.transpose((-volume) * (P * wp.transpose(G)))
    g = Nodes4()
    g[0] = -(F[0] + F[1] + F[2])
    g[1] = F[0]
    g[2] = F[1]
    g[3] = F[2]
    return g


@wp.kernel
def linear_forces(
    nodes: wp.array2d(dtype=int),
    gradients: wp.array(dtype=wp.mat33f),
    volumes: wp.array2d(dtype=float),
    slots: wp.array2d(dtype=int),
    damping: wp.array(dtype=float),
    u: wp.array2d(dtype=wp.vec3f),
    v: wp.array2d(dtype=wp.vec3f),
    law: int,
    mu: float,
    la: float,
    across: wp.vec3f,
    limits: wp.array2d(dtype=wp.vec3f),
    record: int,
    forces: wp.array2d(dtype=wp.vec3f),
    shares: wp.array(dtype=float),
    plastic: wp.array4d(dtype=float),
    peak_squared: wp.array3d(dtype=float),
):
    """Nodal forces −V P ∇N of u + β v [N] into forces[slots[e, a], b], and what flows into plastic[e, point, number, b].

    Recorded steps also raise the stress squared [MPa²].
    """
    e, b = wp.tid()
    G = gradients[e]
    H = linear_gradient(u, nodes, G, e, b) + damping[e] * linear_gradient(v, nodes, G, e, b)
    P = stress_at(H, law, mu, la, across, limits[e, 0], record, e, 0, b, shares, plastic, peak_squared)
    g = corner_forces(P, G, volumes[e, 0])
    for a in range(4):
        forces[slots[e, a], b] = g[a]


@wp.kernel(launch_bounds=(64, 6))  # on an H200 a third faster with eight drops than with 10 blocks, which spill, and than with 4
def quadratic_forces(
    nodes: wp.array2d(dtype=int),
    gradients: wp.array(dtype=wp.mat33f),
    volumes: wp.array2d(dtype=float),
    slots: wp.array2d(dtype=int),
    damping: wp.array(dtype=float),
    u: wp.array2d(dtype=wp.vec3f),
    v: wp.array2d(dtype=wp.vec3f),
    law: int,
    mu: float,
    la: float,
    across: wp.vec3f,
    limits: wp.array2d(dtype=wp.vec3f),
    record: int,
    forces: wp.array2d(dtype=wp.vec3f),
    shares: wp.array(dtype=float),
    plastic: wp.array4d(dtype=float),
    peak_squared: wp.array3d(dtype=float),
):
    """As `linear_forces` for the quadratic element."""
    e, b = wp.tid()
    G = gradients[e]
    x = values_ahead(u, v, damping[e], nodes, e, b)
    common = common_gradient(x, G)
    total = Nodes4()
    f = Nodes10()
    for q in range(4):
        H = quadratic_gradient(common, x, G, q)
        P = stress_at(H, law, mu, la, across, limits[e, q], record, e, q, b, shares, plastic, peak_squared)
        g = corner_forces(P, G, volumes[e, q])
        total += g
        for i in range(4):
            f[BETWEEN[i, q]] += g[i]
    for i in range(4):
        forces[slots[e, i], b] = (FAR - 1.0) * total[i] + (NEAR - FAR) * f[i]
        for j in range(i + 1, 4):
            middle = BETWEEN[i, j]
            forces[slots[e, middle], b] = FAR * (total[i] + total[j]) + (NEAR - FAR) * f[middle]


@wp.func
def gathered(forces: wp.array2d(dtype=wp.vec3f), first_slot: wp.array(dtype=int), i: int, b: int):
    """Sum of the forces in the slots of node i [N], in ascending order of the tetrahedra."""
    total = wp.vec3f()
    for k in range(first_slot[i], first_slot[i + 1]):
        total += forces[k, b]
    return total


@wp.kernel
def gather_forces(
    forces: wp.array2d(dtype=wp.vec3f),
    first_slot: wp.array(dtype=int),
    total: wp.array2d(dtype=wp.vec3f),
):
    """The assembled internal forces alone [N]."""
    i, b = wp.tid()
    total[i, b] = gathered(forces, first_slot, i, b)


@wp.func
def after_contact(v: wp.vec3f, gap: float, n: wp.vec3f, dt: float, friction: float):
    """Velocity that ends the step on the floor [mm/ms], the tangential part clipped by Coulomb's law.

    The normal correction −gap/dt is the impulse per mass that Signorini's condition asks for (kinematic contact: no
    penalty stiffness); friction removes at most μ times that from the tangential velocity.
    """
    push = -gap / dt
    landed = v + push * n
    normal = wp.dot(landed, n) * n
    tangential = landed - normal
    kept = 1.0 - wp.min(1.0, friction * push / wp.max(wp.length(tangential), 1.0e-12))
    return normal + kept * tangential


@wp.kernel
def advance(
    forces: wp.array2d(dtype=wp.vec3f),
    first_slot: wp.array(dtype=int),
    masses: wp.array(dtype=float),
    heights: wp.array2d(dtype=float),
    normals: wp.array(dtype=wp.vec3f),
    dt: float,
    gravity: float,
    friction: float,
    u: wp.array2d(dtype=wp.vec3f),
    v: wp.array2d(dtype=wp.vec3f),
    impulse: wp.array2d(dtype=float),
    contact_loss: wp.array2d(dtype=float),
):
    """Symplectic Euler for one node: v ← v + dt a, contact, u ← u + dt v.

    The floor's work is that of its force on the mean of the velocities before and after the step, as that of every other
    force in the exact change of kinetic energy over a step: zero for a node that rests, m v²/2 for one that lands.
    """
    i, b = wp.tid()
    n = normals[b]
    force = gathered(forces, first_slot, i, b)
    before = v[i, b]
    free = before + dt * (force / masses[i] - gravity * n)
    gap = heights[i, b] + wp.dot(n, u[i, b] + dt * free)
    velocity = free
    if gap < 0.0:
        velocity = after_contact(free, gap, n, dt, friction)
        impulse[i, b] += masses[i] * (-gap / dt)
        contact_loss[i, b] -= 0.5 * masses[i] * wp.dot(velocity - free, before + velocity)
    v[i, b] = velocity
    u[i, b] += dt * velocity


@wp.kernel
def advance_on_penalty(
    forces: wp.array2d(dtype=wp.vec3f),
    first_slot: wp.array(dtype=int),
    masses: wp.array(dtype=float),
    heights: wp.array2d(dtype=float),
    normals: wp.array(dtype=wp.vec3f),
    dt: float,
    gravity: float,
    friction: float,
    stiffness: float,
    u: wp.array2d(dtype=wp.vec3f),
    v: wp.array2d(dtype=wp.vec3f),
    impulse: wp.array2d(dtype=float),
    contact_loss: wp.array2d(dtype=float),
):
    """As `advance`, on a floor that pushes a node with its stiffness times the depth below it, and gives back what it took."""
    i, b = wp.tid()
    n = normals[b]
    force = gathered(forces, first_slot, i, b)
    before = v[i, b]
    velocity = before + dt * (force / masses[i] - gravity * n)
    gap = heights[i, b] + wp.dot(n, u[i, b])
    if gap < 0.0:
        free, push = velocity, -gap * stiffness * dt / masses[i]
        velocity = after_contact(free, -push * dt, n, dt, friction)
        impulse[i, b] += masses[i] * push
        contact_loss[i, b] -= 0.5 * masses[i] * wp.dot(velocity - free, before + velocity)
    v[i, b] = velocity
    u[i, b] += dt * velocity
