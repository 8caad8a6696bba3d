"""The elastic laws and plastic flow as Warp functions, float32, for any device; the formulas are those of `elasticity`.

Plastic flow is J2 with isotropic linear hardening in the multiplicative setting F = F_e F_p, with the neo-Hookean law in b_e = F_e F_eᵀ
(Simo and Hughes 1998, chapter 9). What has flowed is kept as A = C_p⁻¹ − I, so that b_e − I = H + Hᵀ + H Hᵀ + G Fᵀ with G = F A has no
large terms that cancel: small strains are as exact in float32 as in the elastic law. With s = dev b_e, q = tr b_e − 3 and
μ' = μ (3 + q)/(4 + q) the deviator of Kirchhoff stress is μ' s, which is returned radially to the yield surface of radius σ_y + h ε_p.
Flow keeps volume: det b_e = J² gives the new trace. The plastic strain is the one whose work σ_vM dε_p is what flow takes from the elastic
energy: along s it is √(2/3) |Δs| / (2 m) times 1 − tr s³ / (m s:s), tr s³ = 3 det s, in uniaxial tension the true plastic strain.

`limits` of a point are those of `explicit.limits`.
"""

# ruff: noqa: UP018 - float(0.0) declares a Warp variable that changes in a loop, 0.0 a constant

from mechstyle._warp import wp
from mechstyle.fea import explicit

wp.set_module_options({"enable_backward": False})


ELASTIC = wp.constant(explicit.ELASTIC)


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
def factor(q: float, mu: float):
    """Factor k = μ q / (4 (4 + q)) of the law; μ' = 3/4 μ + k."""
    return mu * q / (4.0 * (4.0 + q))


@wp.func
def neo_hookean(H: wp.mat33f, C: wp.mat33f, volume_change: float, k: float, mu: float, la: float):
    """P = 3μ/4 (H + Hᵀ − tr(H) I − cof H) + k F + λ (J − 1) cof F [MPa], C = cof H; what has flowed adds (3μ/4 + k) G."""
    I = wp.identity(n=3, dtype=float)
    tr = wp.trace(H)
    shape = H + wp.transpose(H) - tr * I - C
    cof_F = (1.0 + tr) * I - wp.transpose(H) + C
    return 0.75 * mu * shape + k * (I + H) + la * volume_change * cof_F


@wp.func
def stable_neo_hookean(H: wp.mat33f, mu: float, la: float):
    """P of a body that has not flowed [MPa]."""
    C = cofactor(H)
    tr = wp.trace(H)
    k = factor(2.0 * tr + wp.ddot(H, H), mu)
    return neo_hookean(H, C, tr + wp.trace(C) + wp.dot(H[0], C[0]), k, mu, la)


@wp.func
def first_piola(H: wp.mat33f, mu: float, la: float, law: int):
    """First Piola–Kirchhoff stress [MPa]; `law` is the place of its name in `elasticity.LAWS`."""
    if law == 0:
        return st_venant_kirchhoff(H, mu, la)
    return stable_neo_hookean(H, mu, la)


@wp.func
def energy_density(H: wp.mat33f, G: wp.mat33f, mu: float, la: float, law: int):
    """Ψ [MPa = mJ/mm³], G = F A; x − ln(1 + x) of the neo-Hookean law by the series of artanh, free of cancellation."""
    energy = float(0.0)
    if law == 0:
        E = 0.5 * (H + wp.transpose(H) + wp.transpose(H) * H)
        energy = 0.5 * la * wp.trace(E) * wp.trace(E) + mu * wp.ddot(E, E)
    else:
        C = cofactor(H)
        square = wp.ddot(H, H) + wp.trace(G) + wp.ddot(H, G)
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
def across_layers(T: wp.mat33f, across: wp.vec3f):
    """Square of what pulls or shears printed layers apart, over their share of the strength [MPa²]."""
    squared = float(0.0)
    steep = wp.dot(across, across)
    if steep > 0.0:
        t = T * across
        pull = wp.dot(t, across)
        normal = pull * pull / steep
        squared = 3.0 * (wp.dot(t, t) - normal)
        if pull > 0.0:
            squared = wp.max(squared, normal)
    return squared


@wp.func
def equivalent_squared(H: wp.mat33f, P: wp.mat33f, across: wp.vec3f):
    """Square of `elasticity.equivalent_stress` [MPa²]; `across` is the normal of printed layers over their share of the strength."""
    J = 1.0 + wp.trace(H) + wp.trace(cofactor(H)) + wp.determinant(H)
    return wp.max(von_mises_squared(H, P), across_layers((P + P * wp.transpose(H)) / J, across))


@wp.func
def symmetric(xx: float, yy: float, zz: float, xy: float, yz: float, zx: float):
    """The symmetric matrix with these entries."""
    return wp.mat33f(xx, xy, zx, xy, yy, yz, zx, yz, zz)


@wp.func
def flowed(plastic: wp.array4d(dtype=float), e: int, q: int, b: int):
    """A of what has flowed at a Gauss point."""
    return symmetric(
        plastic[e, q, 0, b], plastic[e, q, 1, b], plastic[e, q, 2, b], plastic[e, q, 3, b], plastic[e, q, 4, b], plastic[e, q, 5, b]
    )


@wp.func
def deviator(H: wp.mat33f, G: wp.mat33f):
    """Deviator s of b_e − I = H + Hᵀ + H Hᵀ + G Fᵀ."""
    c = H + wp.transpose(H) + H * wp.transpose(H) + G + G * wp.transpose(H)
    mean = wp.trace(c) / 3.0
    return symmetric(c[0, 0] - mean, c[1, 1] - mean, c[2, 2] - mean, c[0, 1], c[1, 2], c[0, 2])


@wp.func
def square(s: wp.mat33f):
    """The contraction s:s of a symmetric matrix."""
    normal = s[0, 0] * s[0, 0] + s[1, 1] * s[1, 1] + s[2, 2] * s[2, 2]
    return normal + 2.0 * (s[0, 1] * s[0, 1] + s[1, 2] * s[1, 2] + s[0, 2] * s[0, 2])


@wp.func
def softened(A: wp.mat33f, share: float):
    """As `elasticity.softened`."""
    return 1.0 / wp.max(1.0, share * (1.0 + wp.sqrt(square(A))))


@wp.func
def mean_stress(q: float, change: float, mu: float, la: float):
    """Mean Kirchhoff stress [MPa], `change` = J − 1."""
    return mu * (q * (15.0 + 4.0 * q) / (12.0 * (4.0 + q)) - 0.75 * change) + la * change * (1.0 + change)


@wp.func
def demand_squared(s: wp.mat33f, q: float, change: float, mu: float, la: float, across: wp.vec3f):
    """Square of the Kirchhoff stress that is held against the strength [MPa²]: von Mises', or what pulls or shears layers apart."""
    stiff = 0.75 * mu + factor(q, mu)
    squared = 1.5 * stiff * stiff * square(s)
    if wp.dot(across, across) > 0.0:
        T = stiff * s + mean_stress(q, change, mu, la) * wp.identity(n=3, dtype=float)
        squared = wp.max(squared, across_layers(T, across))
    return squared


@wp.func
def isochoric(half: float, determinant: float, change: float, start: float):
    """Third of the trace of b_e, less 1, that keeps det b_e = J²: m³ − ½ (s:s) m + det s = J² by two Newton steps."""
    wanted = change * (2.0 + change) - determinant + half
    x = start
    x -= (x * (3.0 - half + x * (3.0 + x)) - wanted) / (3.0 * (1.0 + x) * (1.0 + x) - half)
    x -= (x * (3.0 - half + x * (3.0 + x)) - wanted) / (3.0 * (1.0 + x) * (1.0 + x) - half)
    return x


@wp.func
def flows(flow: wp.mat33f, plastic: wp.array4d(dtype=float), e: int, q: int, b: int):
    """What flows now, added to what has flowed at a Gauss point."""
    plastic[e, q, 0, b] = plastic[e, q, 0, b] + flow[0, 0]
    plastic[e, q, 1, b] = plastic[e, q, 1, b] + flow[1, 1]
    plastic[e, q, 2, b] = plastic[e, q, 2, b] + flow[2, 2]
    plastic[e, q, 3, b] = plastic[e, q, 3, b] + flow[0, 1]
    plastic[e, q, 4, b] = plastic[e, q, 4, b] + flow[1, 2]
    plastic[e, q, 5, b] = plastic[e, q, 5, b] + flow[0, 2]


@wp.func
def elastic_plastic(
    H: wp.mat33f,
    mu_new: float,
    la_new: float,
    across: wp.vec3f,
    limits: wp.vec3f,
    record: int,
    e: int,
    q: int,
    b: int,
    shares: wp.array(dtype=float),
    plastic: wp.array4d(dtype=float),
    peak_squared: wp.array3d(dtype=float),
):
    """First Piola–Kirchhoff stress at a Gauss point after it has flowed as far as it must [MPa]; keeps what has flowed.

    Layers that bear less than the solid flow as it does, by a deviator that shrinks as much as they ask for: on the safe side, as pressure
    and pull are left as they are.
    """
    strength, hardening, strain = limits[0], limits[1], plastic[e, q, 6, b]
    G = wp.mat33f()
    mu, la = mu_new, la_new
    if strain > 0.0:
        A = flowed(plastic, e, q, b)
        G = A + H * A
        softer = softened(A, shares[e])
        mu = mu_new * softer
        la = la_new * softer
    C, tr = cofactor(H), wp.trace(H)
    change = tr + wp.trace(C) + wp.dot(H[0], C[0])
    trace_change = 2.0 * tr + wp.ddot(H, H) + wp.trace(G) + wp.ddot(H, G)
    s = deviator(H, G)
    demand, limit = demand_squared(s, trace_change, change, mu, la, across), strength + hardening * strain
    if demand > limit * limit and change > -0.9:
        m = trace_change / 3.0
        stiff = 0.75 * mu + factor(trace_change, mu)
        against = 3.0 * stiff * (1.0 + m)
        along = (1.0 - limit / wp.sqrt(demand)) / (against + hardening)
        lost = against * along
        von_mises = stiff * wp.sqrt(1.5 * square(s))
        after = (1.0 - lost) * s
        half = 0.5 * square(after)
        determinant = wp.determinant(after)
        more = (1.0 - 1.5 * determinant / ((1.0 + m) * (half + 1.0e-20))) * along * von_mises
        x = isochoric(half, determinant, change, m)
        inverse = (wp.identity(n=3, dtype=float) * (1.0 + tr) - wp.transpose(H) + C) / (1.0 + change)  # F⁻ᵀ
        W = ((x - m) * wp.identity(n=3, dtype=float) - lost * s) * inverse
        G += W
        flows(wp.transpose(inverse) * W, plastic, e, q, b)
        plastic[e, q, 6, b] = strain + more
        trace_change = 3.0 * x
        if 3.0 * mean_stress(trace_change, change, mu, la) > -(1.0 - lost) * von_mises:
            plastic[e, q, 7, b] = plastic[e, q, 7, b] + more
        demand = demand * (1.0 - lost) * (1.0 - lost)
    if record == 1:
        peak_squared[e, q, b] = wp.max(peak_squared[e, q, b], limits[2] * demand)
    k = factor(trace_change, mu)
    return neo_hookean(H, C, change, k, mu, la) + (0.75 * mu + k) * G


@wp.func
def stress_at(
    H: wp.mat33f,
    law: int,
    mu: float,
    la: float,
    across: wp.vec3f,
    limits: wp.vec3f,
    record: int,
    e: int,
    q: int,
    b: int,
    shares: wp.array(dtype=float),
    plastic: wp.array4d(dtype=float),
    peak_squared: wp.array3d(dtype=float),
):
    """As `elastic_plastic`, of an elastic body where the strength is that of one."""
    if limits[0] < ELASTIC:
        return elastic_plastic(H, mu, la, across, limits, record, e, q, b, shares, plastic, peak_squared)
    P = first_piola(H, mu, la, law)
    if record == 1:
        peak_squared[e, q, b] = wp.max(peak_squared[e, q, b], limits[2] * equivalent_squared(H, P, across))
    return P
