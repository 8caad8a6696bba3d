"""One drop on one CPU core, sixteen tetrahedra at a time: the lanes are tetrahedra.

State is [node][x y z 0], one row of four floats a node, so that a row is one load; rows of sixteen tetrahedra are transposed into lanes
and back, four in a register, and nodes are moved four at a time. Tetrahedra come in blocks of LANES, their indices and geometry as
[block][quantity][lane]; the last block is filled up with tetrahedra without volume. Forces are added to the nodes in the order of the
tetrahedra: the same inputs give the same bytes.
"""

# mypy: disable-error-code="untyped-decorator,valid-type"
# Warp reads the annotations of its functions itself: they are calls.

from __future__ import annotations

from mechstyle._warp import wp
from mechstyle.fea.backends.simd_code import ALGEBRA, CONTRACT, ELEMENTS, FORCES, PLASTICITY, STRAIN, STRESS, TYPES
from mechstyle.fea.explicit import QUANTITIES

wp.set_module_options({"enable_backward": False})

# Numbers too small for the normal range of floats are taken for zero while a core computes a drop. Ahead of a stress wave displacements
# fall off to 1e-38 mm and below; they mean nothing, but many processors compute with them a hundred times slower: one core of an Intel
# Xeon did 6 million TET10 updates a second with them, 18 without. The mode belongs to the thread, so it is put back before a kernel ends:
# what else runs in the thread, numpy say, computes as before.


@wp.func_native("""
#if defined(__x86_64__)
    const unsigned int before = __builtin_ia32_stmxcsr();
    __builtin_ia32_ldmxcsr(before | 0x8040u);  // flush to zero, denormals are zero
    return before;
#elif defined(__aarch64__)
    unsigned long before;
    __asm__ volatile("mrs %0, fpcr" : "=r"(before));
    __asm__ volatile("msr fpcr, %0" : : "r"(before | (1ul << 24)));  // flush to zero
    return (unsigned int)before;
#else
    return 0u;
#endif
""")
def flush_subnormals() -> wp.uint32:
    """Take subnormal numbers for zero in this thread; returns the mode before, for `restore_mode`."""


@wp.func_native("""
#if defined(__x86_64__)
    __builtin_ia32_ldmxcsr(mode);
#elif defined(__aarch64__)
    __asm__ volatile("msr fpcr, %0" : : "r"((unsigned long)mode));
#endif
""")
def restore_mode(mode: wp.uint32) -> None:
    """Restore the floating-point mode saved by `flush_subnormals`."""


@wp.struct
class LaneBody:
    """A discretised body in blocks."""

    nodes: wp.int32  # of an element: 4 or 10
    blocks: wp.int32
    cellular: wp.int32  # whether it has less than the properties of a solid
    nodes_of: wp.array(dtype=wp.int32)
    geometry: wp.array(dtype=wp.float32)  # ∇L_1, ∇L_2, ∇L_3 (1/mm), volume (mm³)
    masses: wp.array(dtype=wp.float32)  # [node] g
    arms: wp.array(dtype=wp.float32)  # [node][x y z 0] from the centre of mass (mm)


@wp.struct
class LaneState:
    """Drops in progress; see `explicit.Batch` for the quantities."""

    heights: wp.array(dtype=wp.float32)
    u: wp.array(dtype=wp.float32)
    v: wp.array(dtype=wp.float32)
    forces: wp.array(dtype=wp.float32)
    impulse: wp.array(dtype=wp.float32)
    contact_loss: wp.array(dtype=wp.float32)
    peak_squared: wp.array(dtype=wp.float32)
    plastic: wp.array(dtype=wp.float32)  # [block][point][8 numbers][lane], as in `simd_code`
    flowed: wp.array(dtype=wp.int32)  # whether anything has yielded in a block
    samples: wp.array(dtype=wp.float32)


@wp.struct
class LaneScheme:
    """Parameters of one time step; see `explicit.Scheme`."""

    law: wp.int32
    mu: wp.float32
    la: wp.float32
    yields: wp.int32  # whether the material has a yield strength
    yield_strength: wp.float32
    hardening: wp.float32
    time_step: wp.float32
    gravity: wp.float32
    friction: wp.float32
    contact_stiffness: wp.float32  # of a penalty floor at each node, 0 for a rigid floor
    damping: wp.array(dtype=wp.float32)  # β of each tetrahedron, as the blocks lie
    shares: wp.array(dtype=wp.float32)  # likewise
    limits: wp.array(dtype=wp.float32)  # of a cellular body, [block][point][4 numbers][lane], as in `simd_code`
    normals: wp.array(dtype=wp.float32)
    across: wp.vec3f  # normal of printed layers over their share of the strength, zero for none


LANES = 16
"""Tetrahedra in a block: one AVX-512 register of floats. With AVX2 alone 4, 8 and 16 were equally fast."""

_LAYOUT = """
    typedef float Row __attribute__((vector_size(16), aligned(4)));  // x, y, z, 0 of one node
    auto geometry = [&](int block) { return (const Lanes *)body.geometry.data + 10 * block; };
    // Rows of four tetrahedra side by side fill a register; what lies in lanes 4 i + j of it is read as component j of tetrahedron i.
    auto side_by_side = [](Row p, Row q, Row r, Row s) INLINE {
        typedef float Half __attribute__((vector_size(32)));
        const Half pq = __builtin_shufflevector(p, q, 0, 1, 2, 3, 4, 5, 6, 7), rs = __builtin_shufflevector(r, s, 0, 1, 2, 3, 4, 5, 6, 7);
        return (Lanes)__builtin_shufflevector(pq, rs, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    };
    // Within each four lanes: single numbers of a and b in turn, from the lower or upper two; then pairs of them, the lower or upper ones.
    auto lower = [](Lanes a, Lanes b) INLINE {
        return __builtin_shufflevector(a, b, 0, 16, 1, 17, 4, 20, 5, 21, 8, 24, 9, 25, 12, 28, 13, 29);
    };
    auto upper = [](Lanes a, Lanes b) INLINE {
        return __builtin_shufflevector(a, b, 2, 18, 3, 19, 6, 22, 7, 23, 10, 26, 11, 27, 14, 30, 15, 31);
    };
    auto lower_pairs = [](Lanes a, Lanes b) INLINE {
        return __builtin_shufflevector(a, b, 0, 1, 16, 17, 4, 5, 20, 21, 8, 9, 24, 25, 12, 13, 28, 29);
    };
    auto upper_pairs = [](Lanes a, Lanes b) INLINE {
        return __builtin_shufflevector(a, b, 2, 3, 18, 19, 6, 7, 22, 23, 10, 11, 26, 27, 14, 15, 30, 31);
    };
    // Four times four numbers are transposed at once, sixteen tetrahedra in four registers: row(node, lane) of every node of each.
    auto transposed = [&](auto element, int block, Lanes (*buffer)[3], const Lanes **x, auto row) INLINE {
        constexpr int nodes = decltype(element)::nodes;
        const int *numbers = body.nodes_of.data + nodes * LANES * block;
        UNROLL
        for (int a = 0; a < nodes; a++) {
            x[a] = buffer[a];
            auto at = [&](int lane) INLINE { return row(numbers[LANES * a + lane], lane); };
            Lanes r[4];
            UNROLL
            for (int j = 0; j < 4; j++) r[j] = side_by_side(at(j), at(j + 4), at(j + 8), at(j + 12));
            const Lanes xy = lower(r[0], r[1]), xy_2 = lower(r[2], r[3]);
            buffer[a][0] = lower_pairs(xy, xy_2);
            buffer[a][1] = upper_pairs(xy, xy_2);
            buffer[a][2] = lower_pairs(upper(r[0], r[1]), upper(r[2], r[3]));
        }
    };
    auto load = [&](auto element, const float *field, int block, Lanes (*buffer)[3], const Lanes **x) INLINE {
        transposed(element, block, buffer, x, [&](int node, int) INLINE { return ((const Row *)field)[node]; });
    };
    auto load_ahead = [&](auto element, int block, Lanes (*buffer)[3], const Lanes **x) INLINE {
        const float *beta = scheme.damping.data + LANES * block;
        const Row *u = (const Row *)state.u.data, *v = (const Row *)state.v.data;
        transposed(element, block, buffer, x, [&](int node, int lane) INLINE { return u[node] + beta[lane] * v[node]; });
    };
    // The forces are transposed back into rows, which are added tetrahedron by tetrahedron.
    auto add = [&](auto element, int block, auto forces) INLINE {
        constexpr int nodes = decltype(element)::nodes;
        Lanes f[nodes][3];
        forces([&](int a, int k, Lanes value) INLINE { f[a][k] = value; });
        Lanes rows[nodes][4];  // of tetrahedra j, j + 4, j + 8 and j + 12
        UNROLL
        for (int a = 0; a < nodes; a++) {
            const Lanes zero = {}, xy = lower(f[a][0], f[a][1]), z0 = lower(f[a][2], zero);
            const Lanes xy_2 = upper(f[a][0], f[a][1]), z0_2 = upper(f[a][2], zero);
            rows[a][0] = lower_pairs(xy, z0);
            rows[a][1] = upper_pairs(xy, z0);
            rows[a][2] = lower_pairs(xy_2, z0_2);
            rows[a][3] = upper_pairs(xy_2, z0_2);
        }
        const int *numbers = body.nodes_of.data + nodes * LANES * block;
        for (int l = 0; l < LANES; l++)
            for (int a = 0; a < nodes; a++)
                *(Row *)(state.forces.data + 4 * numbers[LANES * a + l]) += ((const Row *)&rows[a][l % 4])[l / 4];
    };
"""

_ADVANCE = (
    CONTRACT
    + """
    typedef float Row __attribute__((vector_size(16), aligned(4)));
    typedef float Rows __attribute__((vector_size(64), aligned(4)));  // of four nodes
    auto of_all = [](Row a) { return __builtin_shufflevector(a, a, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3); };
    auto of_each = [](Row a) { return __builtin_shufflevector(a, a, 0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3); };
    auto dot = [](Row a, Row b) { const Row p = a * b; return p[0] + p[1] + p[2]; };
    const float dt = scheme.time_step, *normal_of = scheme.normals.data, *masses = body.masses.data, *heights = state.heights.data;
    const Row n = {normal_of[0], normal_of[1], normal_of[2], 0.0f}, weight = scheme.gravity * n;
    Row *U = (Row *)state.u.data, *V = (Row *)state.v.data, *F = (Row *)state.forces.data;
    // Moves a node with the velocity it would have in the air, or with what the floor makes of it where that ends below the floor.
    auto move = [&](int i, Row free, float gap) {
        Row velocity = free;
        if (gap < 0.0f) {
            const float push = -gap / dt, mass = masses[i];
            const Row landed = free + push * n, normal = dot(landed, n) * n, tangential = landed - normal;
            const float length = sqrtf(dot(tangential, tangential));
            const float clipped = scheme.friction * push / (length > 1.0e-12f ? length : 1.0e-12f);
            velocity = normal + (clipped < 1.0f ? 1.0f - clipped : 0.0f) * tangential;
            state.impulse.data[i] += mass * push;
            state.contact_loss.data[i] -= 0.5f * mass * dot(velocity - free, V[i] + velocity);
        }
        V[i] = velocity;
        U[i] = U[i] + dt * velocity;
        F[i] = Row{};
    };
    const int count = body.masses.shape[0], fours = count / 4 * 4;
    for (int i = 0; i < fours; i += 4) {  // four nodes at once, and one by one where one of them lands
        Rows &u = *(Rows *)(U + i), &v = *(Rows *)(V + i), &force = *(Rows *)(F + i);
        const Rows free = v + dt * (force / of_each(*(const Row *)(masses + i)) - of_all(weight)), p = of_all(n) * (u + dt * free);
        const Row x = __builtin_shufflevector(p, p, 0, 4, 8, 12), y = __builtin_shufflevector(p, p, 1, 5, 9, 13);
        const Row gap = *(const Row *)(heights + i) + (x + y + __builtin_shufflevector(p, p, 2, 6, 10, 14));
        if (gap[0] < 0.0f || gap[1] < 0.0f || gap[2] < 0.0f || gap[3] < 0.0f) {
            for (int k = 0; k < 4; k++) move(i + k, ((const Row *)&free)[k], gap[k]);
        } else {
            v = free;
            u += dt * free;
            force = Rows{};
        }
    }
    for (int i = fours; i < count; i++) {
        const Row free = V[i] + dt * (F[i] / masses[i] - weight);
        move(i, free, heights[i] + dot(n, U[i] + dt * free));
    }
"""
)

_ADVANCE_ON_PENALTY = (
    CONTRACT
    + """
    typedef float Row __attribute__((vector_size(16), aligned(4)));
    auto dot = [](Row a, Row b) { const Row p = a * b; return p[0] + p[1] + p[2]; };
    const float dt = scheme.time_step, stiffness = scheme.contact_stiffness, *normal_of = scheme.normals.data;
    const Row n = {normal_of[0], normal_of[1], normal_of[2], 0.0f}, weight = scheme.gravity * n;
    Row *U = (Row *)state.u.data, *V = (Row *)state.v.data, *F = (Row *)state.forces.data;
    for (int i = 0; i < body.masses.shape[0]; i++) {
        const float mass = body.masses.data[i], gap = state.heights.data[i] + dot(n, U[i]);
        const Row free = V[i] + dt * (F[i] / mass - weight);
        Row velocity = free;
        if (gap < 0.0f) {
            const float push = -gap * stiffness * dt / mass;
            const Row landed = free + push * n, normal = dot(landed, n) * n, tangential = landed - normal;
            const float length = sqrtf(dot(tangential, tangential));
            const float clipped = scheme.friction * push / (length > 1.0e-12f ? length : 1.0e-12f);
            velocity = normal + (clipped < 1.0f ? 1.0f - clipped : 0.0f) * tangential;
            state.impulse.data[i] += mass * push;
            state.contact_loss.data[i] -= 0.5f * mass * dot(velocity - free, V[i] + velocity);
        }
        V[i] = velocity;
        U[i] = U[i] + dt * velocity;
        F[i] = Row{};
    }
"""
)

_SAMPLE = """
    double kinetic = 0.0, height = 0.0, momentum = 0.0, impulse = 0.0, contact_loss = 0.0, stored = 0.0, work = 0.0, motion[18] = {};
    float highest = 0.0f;
    const float *n = scheme.normals.data;
    for (int i = 0; i < body.masses.shape[0]; i++) {
        const float *u = state.u.data + 4 * i, *v = state.v.data + 4 * i, mass = body.masses.data[i];
        kinetic += 0.5f * mass * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
        height += mass * (u[0] * n[0] + u[1] * n[1] + u[2] * n[2]);
        momentum += mass * (v[0] * n[0] + v[1] * n[1] + v[2] * n[2]);
        impulse += state.impulse.data[i];
        contact_loss += state.contact_loss.data[i];
        const float *arm = body.arms.data + 4 * i;
        for (int k = 0; k < 3; k++) {
            const int a = (k + 1) % 3, b = (k + 2) % 3;
            motion[k] += mass * u[k];
            motion[3 + k] += mass * v[k];
            motion[6 + k] += mass * ((arm[a] + u[a]) * v[b] - (arm[b] + u[b]) * v[a]);
            for (int j = 0; j < 3; j++) motion[9 + 3 * k + j] += mass * u[k] * arm[j];
        }
    }
    for (int l = 0; l < LANES; l++) {
        stored += strain[l];
        work += worked[l];
        highest = peak[l] > highest ? peak[l] : highest;
    }
    const double values[] = {kinetic, stored, impulse, contact_loss, height, momentum, highest, work};
    float *out = state.samples.data + QUANTITIES * row;
    for (int k = 0; k < 8; k++) out[k] = (float)values[k];
    for (int k = 0; k < 18; k++) out[8 + k] = (float)motion[k];
"""

_HEAD = CONTRACT + f"    constexpr int LANES = {LANES}, QUANTITIES = {len(QUANTITIES)};" + TYPES + ALGEBRA + STRESS
_HEAD += PLASTICITY + _LAYOUT + ELEMENTS


@wp.func_native(_HEAD + FORCES)
def element_forces(body: LaneBody, state: LaneState, scheme: LaneScheme, record: int) -> None:
    """Internal forces of all tetrahedra, added to state.forces [N]; if `record`, the running maxima of σ_vM² [MPa²]."""


@wp.func_native(_ADVANCE)
def advance(body: LaneBody, state: LaneState, scheme: LaneScheme) -> None:
    """Symplectic Euler with contact for every node, as `kernels.advance`; clears the forces."""


@wp.func_native(_ADVANCE_ON_PENALTY)
def advance_on_penalty(body: LaneBody, state: LaneState, scheme: LaneScheme) -> None:
    """The same on a penalty floor, as `kernels.advance_on_penalty`."""


@wp.func_native(_HEAD + STRAIN + _SAMPLE)
def sample(body: LaneBody, state: LaneState, scheme: LaneScheme, row: int) -> None:
    """One row of the history, in the order of `explicit.QUANTITIES`."""


@wp.kernel
def forces_only(body: LaneBody, state: LaneState, scheme: LaneScheme, record: int) -> None:
    """The internal forces of u + β v [N], without a step, as `element_forces`."""
    element_forces(body, state, scheme, record)


@wp.kernel
def strides(body: LaneBody, state: LaneState, scheme: LaneScheme, first_row: int, rows: int, steps: int, record_every: int) -> None:
    """`rows` times `steps` steps and a sample."""
    mode = flush_subnormals()
    for row in range(rows):
        for step in range(steps):
            element_forces(body, state, scheme, wp.where(step % record_every == 0, 1, 0))
            if scheme.contact_stiffness > 0.0:
                advance_on_penalty(body, state, scheme)
            else:
                advance(body, state, scheme)
        sample(body, state, scheme, first_row + row)
    restore_mode(mode)
