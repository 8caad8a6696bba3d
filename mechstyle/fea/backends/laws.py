"""The elastic laws as Warp functions, float32, for any device; the formulas are those of `elasticity`."""

# ruff: noqa: UP018 - float(0.0) declares a Warp variable that changes in a loop, 0.0 a constant

from mechstyle._warp import wp

wp.set_module_options({"enable_backward": False})


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
def equivalent_squared(H: wp.mat33f, P: wp.mat33f, across: wp.vec3f):
    """Square of `elasticity.equivalent_stress` [MPa²]; `across` is the normal of printed layers over their share of the strength."""
    squared = von_mises_squared(H, P)
    steep = wp.dot(across, across)
    if steep > 0.0:
        J = 1.0 + wp.trace(H) + wp.trace(cofactor(H)) + wp.determinant(H)
        t = ((P + P * wp.transpose(H)) * across) / J
        pull = wp.dot(t, across)
        normal = pull * pull / steep
        squared = wp.max(squared, 3.0 * (wp.dot(t, t) - normal))
        if pull > 0.0:
            squared = wp.max(squared, normal)
    return squared
