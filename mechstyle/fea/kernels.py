"""One step of the drop test as Warp kernels, float32, for any device; the formulas are those of `elasticity`.

Layout: [vertex][orientation] and [tetrahedron][orientation], orientation fastest, so that neighbouring threads of a GPU
touch neighbouring memory. The element kernel writes each tetrahedron's corner forces to a buffer of its own; the vertex
kernel gathers them in a fixed order. There are no atomic sums, so the same inputs give the same bytes.
"""

# ruff: noqa: UP018 - float(0.0) declares a Warp variable that changes in a loop, 0.0 a constant

from mechstyle.quiet import wp

wp.set_module_options({"enable_backward": False})

PARTS = wp.constant(256)
"""Partial sums per history quantity: parallel enough for a GPU, a fixed order of summation everywhere."""

KINETIC, STRAIN, IMPULSE, CONTACT_LOSS, HEIGHT, MOMENTUM, PEAK = range(7)
"""Places of `integration.QUANTITIES`."""


@wp.func
def cofactor(A: wp.mat33f):
    """Cof A, rows are cross products of the rows of A."""
    a, b, c = A[0], A[1], A[2]
    return wp.matrix_from_rows(wp.cross(b, c), wp.cross(c, a), wp.cross(a, b))


@wp.func
def st_venant_kirchhoff(H: wp.mat33f, mu: float, la: float):
    """P = S + H S, S = λ tr(E) I + 2μ E [MPa]."""
    I = wp.identity(n=3, dtype=float)
    E = 0.5 * (H + wp.transpose(H) + wp.transpose(H) * H)
    S = la * wp.trace(E) * I + 2.0 * mu * E
    return S + H * S


@wp.func
def stable_neo_hookean(H: wp.mat33f, mu: float, la: float):
    """P = 3μ/4 (H + Hᵀ − tr(H) I − cof H) + μ q / (4 (4 + q)) F + λ (J − 1) cof F [MPa]."""
    I = wp.identity(n=3, dtype=float)
    C = cofactor(H)
    tr = wp.trace(H)
    q = 2.0 * tr + wp.ddot(H, H)
    volume_change = tr + wp.trace(C) + wp.dot(H[0], C[0])
    shape = H + wp.transpose(H) - tr * I - C
    cof_F = (1.0 + tr) * I - wp.transpose(H) + C
    return 0.75 * mu * shape + (mu * q / (4.0 * (4.0 + q))) * (I + H) + la * volume_change * cof_F


@wp.func
def first_piola(H: wp.mat33f, mu: float, la: float, law: int):
    """First Piola–Kirchhoff stress [MPa]; `law` is the place of its name in `elasticity.LAWS`."""
    if law == 0:
        return st_venant_kirchhoff(H, mu, la)
    return stable_neo_hookean(H, mu, la)


@wp.func
def energy_density(H: wp.mat33f, mu: float, la: float, law: int):
    """Ψ [MPa = mJ/mm³]; x − ln(1 + x) of the neo-Hookean law by the series of artanh, free of cancellation."""
    energy = float(0.0)
    if law == 0:
        E = 0.5 * (H + wp.transpose(H) + wp.transpose(H) * H)
        energy = 0.5 * la * wp.trace(E) * wp.trace(E) + mu * wp.ddot(E, E)
    else:
        C = cofactor(H)
        square = wp.ddot(H, H)
        minors = wp.trace(C) + wp.dot(H[0], C[0])
        volume_change = wp.trace(H) + minors
        x = 0.25 * (2.0 * wp.trace(H) + square)
        s = x / (2.0 + x)
        remainder = s * (x - s * s * (2.0 / 3.0 + s * s * (2.0 / 5.0 + s * s * 2.0 / 7.0)))
        energy = 0.375 * mu * (square - 2.0 * minors) + 0.5 * mu * remainder + 0.5 * la * volume_change * volume_change
    return energy


@wp.func
def von_mises_squared(H: wp.mat33f, P: wp.mat33f):
    """Square of the equivalent Cauchy stress [MPa²], σ = P Fᵀ / J."""
    J = 1.0 + wp.trace(H) + wp.trace(cofactor(H)) + wp.determinant(H)
    T = P + P * wp.transpose(H)
    a, b, c = T[0, 0] - T[1, 1], T[1, 1] - T[2, 2], T[2, 2] - T[0, 0]
    shear = T[0, 1] * T[0, 1] + T[1, 2] * T[1, 2] + T[2, 0] * T[2, 0]
    return (0.5 * (a * a + b * b + c * c) + 3.0 * shear) / (J * J)


@wp.func
def gradient(field: wp.array2d(dtype=wp.vec3f), tet: wp.vec4i, G: wp.mat33f, b: int):
    """∇ of a vertex field in one tetrahedron and orientation, from differences to corner 0."""
    origin = field[tet[0], b]
    return wp.matrix_from_cols(field[tet[1], b] - origin, field[tet[2], b] - origin, field[tet[3], b] - origin) * G


@wp.kernel
def element_forces(
    tets: wp.array(dtype=wp.vec4i),
    gradients: wp.array(dtype=wp.mat33f),
    volumes: wp.array(dtype=float),
    w: wp.array2d(dtype=wp.vec3f),
    law: int,
    mu: float,
    la: float,
    record: int,
    forces: wp.array3d(dtype=wp.vec3f),
    peak_squared: wp.array2d(dtype=float),
):
    """Corner forces −V P ∇N [N] into forces[e, a, b]; every recorded step also the running maximum of σ_vM² [MPa²]."""
    e, b = wp.tid()
    G = gradients[e]
    H = gradient(w, tets[e], G, b)
    P = first_piola(H, mu, la, law)
    if record == 1:
        peak_squared[e, b] = wp.max(peak_squared[e, b], von_mises_squared(H, P))
    F = wp.transpose((-volumes[e]) * (P * wp.transpose(G)))
    forces[e, 0, b] = -(F[0] + F[1] + F[2])
    forces[e, 1, b] = F[0]
    forces[e, 2, b] = F[1]
    forces[e, 3, b] = F[2]


@wp.func
def gathered(
    forces: wp.array3d(dtype=wp.vec3f), first_corner: wp.array(dtype=int), corners: wp.array(dtype=int), i: int, b: int
):
    """Sum of the corner forces at vertex i [N], in ascending order of the tetrahedra."""
    total = wp.vec3f()
    for k in range(first_corner[i], first_corner[i + 1]):
        corner = corners[k]
        total += forces[corner // 4, corner % 4, b]
    return total


@wp.kernel
def gather_forces(
    forces: wp.array3d(dtype=wp.vec3f),
    first_corner: wp.array(dtype=int),
    corners: wp.array(dtype=int),
    total: wp.array2d(dtype=wp.vec3f),
):
    """The assembled internal forces alone [N], for the power iteration."""
    i, b = wp.tid()
    total[i, b] = gathered(forces, first_corner, corners, i, b)


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
    forces: wp.array3d(dtype=wp.vec3f),
    first_corner: wp.array(dtype=int),
    corners: wp.array(dtype=int),
    masses: wp.array(dtype=float),
    heights: wp.array2d(dtype=float),
    normals: wp.array(dtype=wp.vec3f),
    dt: float,
    damping: float,
    gravity: float,
    friction: float,
    u: wp.array2d(dtype=wp.vec3f),
    v: wp.array2d(dtype=wp.vec3f),
    w: wp.array2d(dtype=wp.vec3f),
    impulse: wp.array2d(dtype=float),
    contact_loss: wp.array2d(dtype=float),
):
    """Symplectic Euler for one vertex: v ← v + dt a, contact, u ← u + dt v, and w = u + β v for the next forces.

    The floor's work is that of its force on the mean of the velocities before and after the step, as that of every other
    force in the exact change of kinetic energy over a step: zero for a vertex that rests, m v²/2 for one that lands.
    """
    i, b = wp.tid()
    n = normals[b]
    force = gathered(forces, first_corner, corners, i, b)
    before = v[i, b]
    free = before + dt * (force / masses[i] - gravity * n)
    gap = heights[i, b] + wp.dot(n, u[i, b] + dt * free)
    velocity = free
    if gap < 0.0:
        velocity = after_contact(free, gap, n, dt, friction)
        impulse[i, b] += masses[i] * (-gap / dt)
        contact_loss[i, b] -= 0.5 * masses[i] * wp.dot(velocity - free, before + velocity)
    displacement = u[i, b] + dt * velocity
    v[i, b] = velocity
    u[i, b] = displacement
    w[i, b] = displacement + damping * velocity


@wp.kernel
def sample_parts(
    tets: wp.array(dtype=wp.vec4i),
    gradients: wp.array(dtype=wp.mat33f),
    volumes: wp.array(dtype=float),
    masses: wp.array(dtype=float),
    normals: wp.array(dtype=wp.vec3f),
    law: int,
    mu: float,
    la: float,
    dt: float,
    u: wp.array2d(dtype=wp.vec3f),
    v: wp.array2d(dtype=wp.vec3f),
    impulse: wp.array2d(dtype=float),
    contact_loss: wp.array2d(dtype=float),
    parts: wp.array3d(dtype=float),
):
    """The history quantities of every PARTS-th element and vertex, into parts[quantity, part, b].

    Velocities belong to the middle of the step that led to the displacements, so strain energy is taken there too,
    U − Δt/2 dU/dt: with kinetic energy this is what central differences conserve exactly in a linear body.
    """
    part, b = wp.tid()
    strain, peak = float(0.0), float(0.0)
    for e in range(part, tets.shape[0], PARTS):
        H = gradient(u, tets[e], gradients[e], b)
        rate = gradient(v, tets[e], gradients[e], b)
        P = first_piola(H, mu, la, law)
        strain += volumes[e] * (energy_density(H, mu, la, law) - 0.5 * dt * wp.ddot(P, rate))
        peak = wp.max(peak, von_mises_squared(H, P))
    kinetic, height, momentum = float(0.0), float(0.0), float(0.0)
    pushed, lost = float(0.0), float(0.0)
    for i in range(part, masses.shape[0], PARTS):
        kinetic += 0.5 * masses[i] * wp.dot(v[i, b], v[i, b])
        height += masses[i] * wp.dot(u[i, b], normals[b])
        momentum += masses[i] * wp.dot(v[i, b], normals[b])
        pushed += impulse[i, b]
        lost += contact_loss[i, b]
    parts[KINETIC, part, b] = kinetic
    parts[STRAIN, part, b] = strain
    parts[IMPULSE, part, b] = pushed
    parts[CONTACT_LOSS, part, b] = lost
    parts[HEIGHT, part, b] = height
    parts[MOMENTUM, part, b] = momentum
    parts[PEAK, part, b] = peak


@wp.kernel
def sample_total(parts: wp.array3d(dtype=float), row: wp.array(dtype=int), samples: wp.array3d(dtype=float)):
    """Sum the parts (maximum for PEAK) into the current row of samples[row, quantity, b]."""
    quantity, b = wp.tid()
    total = float(0.0)
    for part in range(PARTS):
        if quantity == PEAK:
            total = wp.max(total, parts[quantity, part, b])
        else:
            total += parts[quantity, part, b]
    samples[row[0], quantity, b] = total


@wp.kernel
def next_row(row: wp.array(dtype=int)):
    """Count the samples on the device, so that a captured graph can be replayed without the host."""
    row[0] = row[0] + 1
