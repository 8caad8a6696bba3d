"""Samples of the history as Warp kernels, for any device: sums in parts, each over some elements or nodes, and then over the parts."""

# ruff: noqa: UP018 - float(0.0) declares a Warp variable that changes in a loop, 0.0 a constant

from mechstyle._warp import wp
from mechstyle.fea.backends.kernels import common_gradient, linear_gradient, nodal_values, quadratic_gradient
from mechstyle.fea.backends.laws import (
    ELASTIC,
    cofactor,
    demand_squared,
    deviator,
    energy_density,
    equivalent_squared,
    factor,
    first_piola,
    flowed,
    neo_hookean,
    softened,
)

wp.set_module_options({"enable_backward": False})

PARTS, GROUPS = wp.constant(4096), wp.constant(64)
"""Partial sums per history quantity, and groups of them that are added up before the groups are: parallel enough for a GPU, a fixed order
of summation everywhere."""

KINETIC, STRAIN, IMPULSE, CONTACT_LOSS, HEIGHT, MOMENTUM, PEAK, PLASTIC_WORK, MOTION = range(9)
"""Places of `explicit.QUANTITIES`; from MOTION on those of `explicit.MOTION`."""


@wp.func
def of_point(
    H: wp.mat33f,
    rate: wp.mat33f,
    law: int,
    mu_new: float,
    la_new: float,
    across: wp.vec3f,
    limit: wp.vec3f,
    dt: float,
    e: int,
    q: int,
    b: int,
    shares: wp.array(dtype=float),
    plastic: wp.array4d(dtype=float),
):
    """Strain energy density half a step ago [MPa], density of plastic work so far [MPa] and stress squared now [MPa²] at a Gauss point.

    Velocities belong to the middle of the step that led to the displacements, so strain energy is taken there too,
    U − Δt/2 dU/dt: with kinetic energy this is what central differences conserve exactly in a linear body.
    """
    work, squared = float(0.0), float(0.0)
    G, P = wp.mat33f(), wp.mat33f()
    mu, la = mu_new, la_new
    strength, hardening = limit[0], limit[1]
    if strength < ELASTIC:
        strain = plastic[e, q, 6, b]
        if strain > 0.0:
            A = flowed(plastic, e, q, b)
            G = A + H * A
            softer = softened(A, shares[e])
            mu = mu_new * softer
            la = la_new * softer
            work = strain * (strength + 0.5 * hardening * strain)
        C = cofactor(H)
        change = wp.trace(H) + wp.trace(C) + wp.dot(H[0], C[0])
        trace_change = 2.0 * wp.trace(H) + wp.ddot(H, H) + wp.trace(G) + wp.ddot(H, G)
        k = factor(trace_change, mu)
        P = neo_hookean(H, C, change, k, mu, la) + (0.75 * mu + k) * G
        squared = demand_squared(deviator(H, G), trace_change, change, mu, la, across)
    else:
        P = first_piola(H, mu, la, law)
        squared = equivalent_squared(H, P, across)
    return wp.vec3f(energy_density(H, G, mu, la, law) - 0.5 * dt * wp.ddot(P, rate), work, limit[2] * squared)


@wp.kernel
def sample_elements(
    nodes: wp.array2d(dtype=int),
    gradients: wp.array(dtype=wp.mat33f),
    volumes: wp.array2d(dtype=float),
    law: int,
    mu: float,
    la: float,
    across: wp.vec3f,
    limits: wp.array2d(dtype=wp.vec3f),
    dt: float,
    u: wp.array2d(dtype=wp.vec3f),
    v: wp.array2d(dtype=wp.vec3f),
    shares: wp.array(dtype=float),
    plastic: wp.array4d(dtype=float),
    parts: wp.array3d(dtype=float),
):
    """Strain energy, plastic work and peak of every PARTS-th element into parts[quantity, part, b]."""
    part, b = wp.tid()
    strain, work, peak = float(0.0), float(0.0), float(0.0)
    for e in range(part, nodes.shape[0], PARTS):
        G = gradients[e]
        if nodes.shape[1] == 4:
            H = linear_gradient(u, nodes, G, e, b)
            rate = linear_gradient(v, nodes, G, e, b)
            at = of_point(H, rate, law, mu, la, across, limits[e, 0], dt, e, 0, b, shares, plastic)
            strain += volumes[e, 0] * at[0]
            work += volumes[e, 0] * at[1]
            peak = wp.max(peak, at[2])
        else:
            x = nodal_values(u, nodes, e, b)
            y = nodal_values(v, nodes, e, b)
            x_common = common_gradient(x, G)
            y_common = common_gradient(y, G)
            for q in range(4):
                H = quadratic_gradient(x_common, x, G, q)
                rate = quadratic_gradient(y_common, y, G, q)
                at = of_point(H, rate, law, mu, la, across, limits[e, q], dt, e, q, b, shares, plastic)
                strain += volumes[e, q] * at[0]
                work += volumes[e, q] * at[1]
                peak = wp.max(peak, at[2])
    parts[STRAIN, part, b] = strain
    parts[PLASTIC_WORK, part, b] = work
    parts[PEAK, part, b] = peak


@wp.kernel
def sample_nodes(
    masses: wp.array(dtype=float),
    normals: wp.array(dtype=wp.vec3f),
    u: wp.array2d(dtype=wp.vec3f),
    v: wp.array2d(dtype=wp.vec3f),
    impulse: wp.array2d(dtype=float),
    contact_loss: wp.array2d(dtype=float),
    parts: wp.array3d(dtype=float),
):
    """The sums over every PARTS-th node into parts[quantity, part, b]."""
    part, b = wp.tid()
    kinetic, height, momentum = float(0.0), float(0.0), float(0.0)
    pushed, lost = float(0.0), float(0.0)
    for i in range(part, masses.shape[0], PARTS):
        kinetic += 0.5 * masses[i] * wp.dot(v[i, b], v[i, b])
        height += masses[i] * wp.dot(u[i, b], normals[b])
        momentum += masses[i] * wp.dot(v[i, b], normals[b])
        pushed += impulse[i, b]
        lost += contact_loss[i, b]
    parts[KINETIC, part, b] = kinetic
    parts[IMPULSE, part, b] = pushed
    parts[CONTACT_LOSS, part, b] = lost
    parts[HEIGHT, part, b] = height
    parts[MOMENTUM, part, b] = momentum


@wp.kernel
def sample_motion(
    masses: wp.array(dtype=float),
    arms: wp.array(dtype=wp.vec3f),
    u: wp.array2d(dtype=wp.vec3f),
    v: wp.array2d(dtype=wp.vec3f),
    parts: wp.array3d(dtype=float),
):
    """The sums that tell the motion as a whole, over every PARTS-th node."""
    part, b = wp.tid()
    shift, momentum, spin, turn = wp.vec3f(), wp.vec3f(), wp.vec3f(), wp.mat33f()
    for i in range(part, masses.shape[0], PARTS):
        shift += masses[i] * u[i, b]
        momentum += masses[i] * v[i, b]
        spin += masses[i] * wp.cross(arms[i] + u[i, b], v[i, b])
        turn += masses[i] * wp.outer(u[i, b], arms[i])
    for k in range(3):
        parts[MOTION + k, part, b] = shift[k]
        parts[MOTION + 3 + k, part, b] = momentum[k]
        parts[MOTION + 6 + k, part, b] = spin[k]
        for j in range(3):
            parts[MOTION + 9 + 3 * k + j, part, b] = turn[k, j]


@wp.func
def together(one: float, other: float, quantity: int):
    """The sum of two partial sums, the maximum for PEAK."""
    if quantity == PEAK:
        return wp.max(one, other)
    return one + other


@wp.kernel
def sample_groups(parts: wp.array3d(dtype=float), groups: wp.array3d(dtype=float)):
    """Every GROUPS-th part together, into groups[quantity, group, b]."""
    quantity, group, b = wp.tid()
    total = float(0.0)
    for part in range(group, PARTS, GROUPS):
        total = together(total, parts[quantity, part, b], quantity)
    groups[quantity, group, b] = total


@wp.kernel
def sample_total(groups: wp.array3d(dtype=float), row: wp.array(dtype=int), samples: wp.array3d(dtype=float)):
    """The groups together, into the current row of samples[row, quantity, b]."""
    quantity, b = wp.tid()
    total = float(0.0)
    for group in range(GROUPS):
        total = together(total, groups[quantity, group, b], quantity)
    samples[row[0], quantity, b] = total


@wp.kernel
def next_row(row: wp.array(dtype=int)):
    """Count the samples on the device, so that a captured graph can be replayed without the host."""
    row[0] = row[0] + 1
