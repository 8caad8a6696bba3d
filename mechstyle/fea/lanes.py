"""One drop on one CPU core: eight tetrahedra at a time, in vector registers.

Warp compiles kernels for the CPU without vectorising them; these are the same steps as in `kernels` written with the
vector extensions of clang, the compiler inside Warp. They are portable: the compiler maps the eight lanes to whatever the
processor has (one AVX register, two of SSE or NEON). Five times as fast as the plain kernels, tested against the same reference.

State is [vertex][x y z 0], one row of four floats a vertex, so that a row is one load. Tetrahedra come in blocks of LANES,
their indices and geometry transposed, [block][quantity][lane]; the last block is filled up with tetrahedra without volume.
Forces are added to the vertices in the order of the tetrahedra: the same inputs give the same bytes.
"""

# mypy: disable-error-code="untyped-decorator,valid-type"
# Warp reads the annotations of its functions itself: they are calls.

from __future__ import annotations

from mechstyle.quiet import wp

wp.set_module_options({"enable_backward": False})

LANES = 8
"""Tetrahedra in a block: one AVX register of floats; 4 and 16 are no faster, even where registers hold 16."""


@wp.struct
class LaneBody:
    """A discretised body in blocks of LANES tetrahedra."""

    tets: wp.array(dtype=wp.int32)  # [block][corner][lane]
    geometry: wp.array(dtype=wp.float32)  # [block][∇N_1, ∇N_2, ∇N_3 (1/mm), volume (mm³)][lane]
    masses: wp.array(dtype=wp.float32)  # [vertex] g


@wp.struct
class LaneState:
    """One drop in progress; see `integration.Batch` for the quantities."""

    heights: wp.array(dtype=wp.float32)
    u: wp.array(dtype=wp.float32)
    v: wp.array(dtype=wp.float32)
    w: wp.array(dtype=wp.float32)
    forces: wp.array(dtype=wp.float32)
    impulse: wp.array(dtype=wp.float32)
    contact_loss: wp.array(dtype=wp.float32)
    peak_squared: wp.array(dtype=wp.float32)
    samples: wp.array(dtype=wp.float32)


@wp.struct
class LaneScheme:
    """What one step does; see `integration.Scheme`."""

    law: wp.int32
    mu: wp.float32
    la: wp.float32
    time_step: wp.float32
    damping: wp.float32
    gravity: wp.float32
    friction: wp.float32
    normal: wp.vec3f


_TYPES = f"    constexpr int LANES = {LANES};" + """
    typedef float Lanes __attribute__((vector_size(4 * LANES), aligned(4)));  // one number for each tetrahedron of a block
    typedef float Row __attribute__((vector_size(16), aligned(4)));           // x, y, z, 0 of one vertex
    struct Matrix {
        Lanes entry[3][3];
        Lanes *operator[](int i) { return entry[i]; }
        const Lanes *operator[](int i) const { return entry[i]; }
    };
    auto trace = [](const Matrix &A) { return A[0][0] + A[1][1] + A[2][2]; };
    auto contraction = [](const Matrix &A, const Matrix &B) {
        Lanes sum = {};
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++) sum += A[i][j] * B[i][j];
        return sum;
    };
    auto cofactor = [](const Matrix &A) {
        Matrix C;
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++) {
                const int a = (i + 1) % 3, b = (i + 2) % 3, c = (j + 1) % 3, d = (j + 2) % 3;
                C[i][j] = A[a][c] * A[b][d] - A[a][d] * A[b][c];
            }
        return C;
    };
    // J - 1 = tr H + tr cof H + det H
    auto volume_change = [&](const Matrix &H, const Matrix &C) {
        return trace(H) + trace(C) + (H[0][0] * C[0][0] + H[0][1] * C[0][1] + H[0][2] * C[0][2]);
    };
"""

_STRESS = """
    const float mu = scheme.mu, la = scheme.la;
    auto green_strain = [](const Matrix &H) {
        Matrix E;
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++)
                E[i][j] = 0.5f * (H[i][j] + H[j][i] + H[0][i] * H[0][j] + H[1][i] * H[1][j] + H[2][i] * H[2][j]);
        return E;
    };
    auto st_venant_kirchhoff = [&](const Matrix &H) {
        Matrix S = green_strain(H), P;
        const Lanes spherical = la * trace(S);
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++) S[i][j] = 2.0f * mu * S[i][j] + (i == j ? spherical : Lanes{});
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++) P[i][j] = S[i][j] + H[i][0] * S[0][j] + H[i][1] * S[1][j] + H[i][2] * S[2][j];
        return P;
    };
    auto stable_neo_hookean = [&](const Matrix &H) {
        const Matrix C = cofactor(H);
        const Lanes tr = trace(H), q = 2.0f * tr + contraction(H, H), k = mu * q / (4.0f * (4.0f + q));
        const Lanes pressure = la * volume_change(H, C);
        const float m = 0.75f * mu;
        Matrix P;
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++) {
                P[i][j] = m * (H[i][j] + H[j][i] - C[i][j]) + k * H[i][j] + pressure * (C[i][j] - H[j][i]);
                if (i == j) P[i][j] += k + pressure + (pressure - m) * tr;
            }
        return P;
    };
    auto first_piola = [&](const Matrix &H) { return scheme.law == 0 ? st_venant_kirchhoff(H) : stable_neo_hookean(H); };
    auto von_mises_squared = [&](const Matrix &H, const Matrix &P) {
        Matrix T;  // Kirchhoff stress J sigma = P F^T
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++) T[i][j] = P[i][j] + P[i][0] * H[j][0] + P[i][1] * H[j][1] + P[i][2] * H[j][2];
        const Lanes a = T[0][0] - T[1][1], b = T[1][1] - T[2][2], c = T[2][2] - T[0][0];
        const Lanes shear = T[0][1] * T[0][1] + T[1][2] * T[1][2] + T[2][0] * T[2][0], J = 1.0f + volume_change(H, cofactor(H));
        return (0.5f * (a * a + b * b + c * c) + 3.0f * shear) / (J * J);
    };
"""

_GRADIENT = """
    // The gradient of a vertex field in a block: four rows at a time are loaded and transposed into lanes.
    auto gradient = [&](const float *field, int block) __attribute__((always_inline)) {
        const int *corners = body.tets.data + 4 * LANES * block;
        const Lanes *G = (const Lanes *)(body.geometry.data + 10 * LANES * block);
        Lanes x[4][3];
        for (int c = 0; c < 4; c++)
            for (int l = 0; l < LANES; l += 4) {
                const int *vertex = corners + LANES * c + l;
                const Row p = *(const Row *)(field + 4 * vertex[0]), q = *(const Row *)(field + 4 * vertex[1]);
                const Row r = *(const Row *)(field + 4 * vertex[2]), s = *(const Row *)(field + 4 * vertex[3]);
                const Row pq = __builtin_shufflevector(p, q, 0, 4, 1, 5), rs = __builtin_shufflevector(r, s, 0, 4, 1, 5);
                ((Row *)&x[c][0])[l / 4] = __builtin_shufflevector(pq, rs, 0, 1, 4, 5);
                ((Row *)&x[c][1])[l / 4] = __builtin_shufflevector(pq, rs, 2, 3, 6, 7);
                const Row pq_z = __builtin_shufflevector(p, q, 2, 6, 3, 7), rs_z = __builtin_shufflevector(r, s, 2, 6, 3, 7);
                ((Row *)&x[c][2])[l / 4] = __builtin_shufflevector(pq_z, rs_z, 0, 1, 4, 5);
            }
        Matrix H;
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++)
                H[i][j] = (x[1][i] - x[0][i]) * G[j] + (x[2][i] - x[0][i]) * G[3 + j] + (x[3][i] - x[0][i]) * G[6 + j];
        return H;
    };
"""

_ELEMENT_FORCES = _TYPES + _STRESS + _GRADIENT + """
    // Adds f_a = -V P grad N_a to the vertices, lane by lane, so that the order of summation is that of the tetrahedra.
    const int blocks = body.tets.shape[0] / (4 * LANES);
    Lanes *peak = (Lanes *)state.peak_squared.data;
    for (int block = 0; block < blocks; block++) {
        const Matrix H = gradient(state.w.data, block), P = first_piola(H);
        if (record) {
            const Lanes now = von_mises_squared(H, P), before = peak[block];
            peak[block] = now > before ? now : before;
        }
        const Lanes *G = (const Lanes *)(body.geometry.data + 10 * LANES * block);
        Lanes f[4][3];
        for (int i = 0; i < 3; i++) {
            for (int a = 0; a < 3; a++) f[a + 1][i] = -G[9] * (P[i][0] * G[3 * a] + P[i][1] * G[3 * a + 1] + P[i][2] * G[3 * a + 2]);
            f[0][i] = -(f[1][i] + f[2][i] + f[3][i]);
        }
        Row rows[4][LANES];
        for (int c = 0; c < 4; c++)
            for (int l = 0; l < LANES; l += 4) {
                const Row x = ((Row *)&f[c][0])[l / 4], y = ((Row *)&f[c][1])[l / 4], z = ((Row *)&f[c][2])[l / 4], zero = {};
                const Row xy = __builtin_shufflevector(x, y, 0, 4, 1, 5), xy_2 = __builtin_shufflevector(x, y, 2, 6, 3, 7);
                const Row z0 = __builtin_shufflevector(z, zero, 0, 4, 1, 5), z0_2 = __builtin_shufflevector(z, zero, 2, 6, 3, 7);
                rows[c][l] = __builtin_shufflevector(xy, z0, 0, 1, 4, 5);
                rows[c][l + 1] = __builtin_shufflevector(xy, z0, 2, 3, 6, 7);
                rows[c][l + 2] = __builtin_shufflevector(xy_2, z0_2, 0, 1, 4, 5);
                rows[c][l + 3] = __builtin_shufflevector(xy_2, z0_2, 2, 3, 6, 7);
            }
        const int *corners = body.tets.data + 4 * LANES * block;
        for (int l = 0; l < LANES; l++)
            for (int c = 0; c < 4; c++) *(Row *)(state.forces.data + 4 * corners[LANES * c + l]) += rows[c][l];
    }
"""

_ADVANCE = """
    typedef float Row __attribute__((vector_size(16), aligned(4)));
    auto dot = [](Row a, Row b) { const Row p = a * b; return p[0] + p[1] + p[2]; };
    const float dt = scheme.time_step, beta = scheme.damping;
    const Row n = {scheme.normal[0], scheme.normal[1], scheme.normal[2], 0.0f}, weight = scheme.gravity * n;
    Row *U = (Row *)state.u.data, *V = (Row *)state.v.data, *W = (Row *)state.w.data, *F = (Row *)state.forces.data;
    for (int i = 0; i < body.masses.shape[0]; i++) {
        const float mass = body.masses.data[i];
        const Row before = V[i], free = before + dt * (F[i] / mass - weight);
        const float gap = state.heights.data[i] + dot(n, U[i] + dt * free);
        Row velocity = free;
        if (gap < 0.0f) {
            const float push = -gap / dt;
            const Row landed = free + push * n, normal = dot(landed, n) * n, tangential = landed - normal;
            const float length = sqrtf(dot(tangential, tangential));
            const float clipped = scheme.friction * push / (length > 1.0e-12f ? length : 1.0e-12f);
            velocity = normal + (clipped < 1.0f ? 1.0f - clipped : 0.0f) * tangential;
            state.impulse.data[i] += mass * push;
            state.contact_loss.data[i] -= 0.5f * mass * dot(velocity - free, before + velocity);
        }
        V[i] = velocity;
        U[i] = U[i] + dt * velocity;
        W[i] = U[i] + beta * velocity;
        F[i] = Row{};
    }
"""

_SAMPLE = _TYPES + _STRESS + _GRADIENT + """
    auto energy_density = [&](const Matrix &H) {
        if (scheme.law == 0) {
            const Matrix E = green_strain(H);
            return 0.5f * la * trace(E) * trace(E) + mu * contraction(E, E);
        }
        const Matrix C = cofactor(H);
        const Lanes change = volume_change(H, C), square = contraction(H, H), x = 0.25f * (2.0f * trace(H) + square);
        const Lanes s = x / (2.0f + x);  // x - ln(1 + x) by the series of artanh s
        const Lanes remainder = s * (x - s * s * (2.0f / 3.0f + s * s * (2.0f / 5.0f + s * s * 2.0f / 7.0f)));
        return 0.375f * mu * (square - 2.0f * (change - trace(H))) + 0.5f * mu * remainder + 0.5f * la * change * change;
    };
    Lanes strain = {}, peak = {};
    for (int block = 0; block < body.tets.shape[0] / (4 * LANES); block++) {
        const Lanes volume = ((const Lanes *)(body.geometry.data + 10 * LANES * block))[9];
        const Matrix H = gradient(state.u.data, block), rate = gradient(state.v.data, block), P = first_piola(H);
        const Lanes now = von_mises_squared(H, P);
        strain += volume * (energy_density(H) - 0.5f * scheme.time_step * contraction(P, rate));
        peak = now > peak ? now : peak;
    }
    double kinetic = 0.0, height = 0.0, momentum = 0.0, impulse = 0.0, contact_loss = 0.0;
    for (int i = 0; i < body.masses.shape[0]; i++) {
        const float *u = state.u.data + 4 * i, *v = state.v.data + 4 * i, mass = body.masses.data[i];
        kinetic += 0.5f * mass * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
        height += mass * (u[0] * scheme.normal[0] + u[1] * scheme.normal[1] + u[2] * scheme.normal[2]);
        momentum += mass * (v[0] * scheme.normal[0] + v[1] * scheme.normal[1] + v[2] * scheme.normal[2]);
        impulse += state.impulse.data[i];
        contact_loss += state.contact_loss.data[i];
    }
    double stored = 0.0;
    float highest = 0.0f;
    for (int l = 0; l < LANES; l++) {
        stored += strain[l];
        highest = peak[l] > highest ? peak[l] : highest;
    }
    const double values[] = {kinetic, stored, impulse, contact_loss, height, momentum, highest};
    for (int k = 0; k < 7; k++) state.samples.data[7 * row + k] = (float)values[k];
"""


@wp.func_native(_ELEMENT_FORCES)
def element_forces(body: LaneBody, state: LaneState, scheme: LaneScheme, record: int) -> None:
    """Internal forces of all tetrahedra, added to state.forces [N]; if `record`, the running maximum of σ_vM² [MPa²]."""


@wp.func_native(_ADVANCE)
def advance(body: LaneBody, state: LaneState, scheme: LaneScheme) -> None:
    """Symplectic Euler with contact for every vertex, as `kernels.advance`; clears the forces."""


@wp.func_native(_SAMPLE)
def sample(body: LaneBody, state: LaneState, scheme: LaneScheme, row: int) -> None:
    """One row of the history, in the order of `kernels.KINETIC` to `kernels.PEAK`."""


@wp.kernel
def forces_only(body: LaneBody, state: LaneState, scheme: LaneScheme) -> None:
    """The internal forces of the displacement in state.w [N], for the power iteration."""
    element_forces(body, state, scheme, 0)


@wp.kernel
def strides(body: LaneBody, state: LaneState, scheme: LaneScheme, first_row: int, rows: int, steps: int, record_every: int) -> None:
    """`rows` times `steps` steps and a sample."""
    for row in range(rows):
        for step in range(steps):
            element_forces(body, state, scheme, wp.where(step % record_every == 0, 1, 0))
            advance(body, state, scheme)
        sample(body, state, scheme, first_row + row)
