"""The element arithmetic of the CPU kernels as C++ text: a number becomes a vector of lanes, all else stays as in the textbook.

Warp compiles kernels for the CPU without vectorising them. These are the same steps as in `kernels`, written with the vector
extensions of clang, the compiler inside Warp: `Lanes` adds and multiplies like a float, and the compiler maps it to whatever the
processor has (AVX, SSE or NEON registers, one or several). What lies in the lanes is for the layout to say: sixteen tetrahedra of one
drop (`simd_by_element`). It provides `load`, `load_ahead` (u + β v), `geometry` and `add`; all here is written in terms of these.
`Linear` and `Quadratic` are the elements of `elements`. Element, law and whether stress is recorded are types, so that each of their
loops is compiled on its own: a tenth faster than asking at every Gauss point.
"""

from __future__ import annotations

from mechstyle.fea.elements import GAUSS_A, GAUSS_B

CONTRACT = """
    _Pragma("clang fp contract(fast)")  // a * b + c is one operation; must be the first line of a function
"""

TYPES = """
    #define INLINE __attribute__((always_inline))
    #define UNROLL _Pragma("clang loop unroll(full)")
    typedef float Lanes __attribute__((vector_size(4 * LANES), aligned(4)));
    typedef double DoubleLanes __attribute__((vector_size(8 * LANES), aligned(8)));
    struct Matrix {
        Lanes entry[3][3];
        Lanes *operator[](int i) { return entry[i]; }
        const Lanes *operator[](int i) const { return entry[i]; }
    };
    struct Linear { enum { nodes = 4, points = 1 }; };
    struct Quadratic { enum { nodes = 10, points = 4 }; };
    struct Kirchhoff { enum { neo_hookean = 0 }; };
    struct NeoHookean { enum { neo_hookean = 1 }; };
    struct Unrecorded { enum { record = 0 }; };
    struct Recorded { enum { record = 1 }; };
"""

ALGEBRA = """
    auto trace = [](const Matrix &A) { return A[0][0] + A[1][1] + A[2][2]; };
    auto contraction = [](const Matrix &A, const Matrix &B) {
        Lanes sum[3];  // one for each row: a single sum would wait nine times for its last term
        for (int i = 0; i < 3; i++) sum[i] = A[i][0] * B[i][0] + A[i][1] * B[i][1] + A[i][2] * B[i][2];
        return sum[0] + sum[1] + sum[2];
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

STRESS = """
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
        const float m = 0.75f * mu;
        const Lanes pressure = la * volume_change(H, C), excess = pressure - m, diagonal = k + pressure + excess * tr;
        Matrix P;
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++) P[i][j] = (m + k) * H[i][j] + excess * (C[i][j] - H[j][i]) + (i == j ? diagonal : Lanes{});
        return P;
    };
    auto first_piola = [&](auto law, const Matrix &H) INLINE {
        if constexpr (decltype(law)::neo_hookean) return stable_neo_hookean(H);
        else return st_venant_kirchhoff(H);
    };
    auto max = [](const Lanes &a, const Lanes &b) { return a > b ? a : b; };
    const float across[3] = {scheme.across[0], scheme.across[1], scheme.across[2]};
    const float steep = across[0] * across[0] + across[1] * across[1] + across[2] * across[2];
    // What pulls or shears printed layers apart, over their share of the strength, squared.
    auto across_layers = [&](const Matrix &T) {
        if (steep == 0.0f) return Lanes{};
        Lanes pull = {}, square = {};
        for (int i = 0; i < 3; i++) {
            const Lanes traction = T[i][0] * across[0] + T[i][1] * across[1] + T[i][2] * across[2];
            pull += traction * across[i];
            square += traction * traction;
        }
        const Lanes normal = pull * pull / steep;
        return max(3.0f * (square - normal), pull > 0.0f ? normal : Lanes{});
    };
    auto equivalent_squared = [&](const Matrix &H, const Matrix &P) {
        Matrix T;  // Kirchhoff stress J sigma = P F^T
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++) T[i][j] = P[i][j] + P[i][0] * H[j][0] + P[i][1] * H[j][1] + P[i][2] * H[j][2];
        const Lanes a = T[0][0] - T[1][1], b = T[1][1] - T[2][2], c = T[2][2] - T[0][0];
        const Lanes shear = T[0][1] * T[0][1] + T[1][2] * T[1][2] + T[2][0] * T[2][0], J = 1.0f + volume_change(H, cofactor(H));
        const Lanes of_solid = 0.5f * (a * a + b * b + c * c) + 3.0f * shear;
        return max(of_solid, across_layers(T)) / (J * J);
    };
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
"""

ELEMENTS = (
    f"    constexpr float NEAR = 4.0f * {GAUSS_A}f, FAR = 4.0f * {GAUSS_B}f, SELF = FAR - 1.0f, EXTRA = NEAR - FAR;"
    """
    // Node between corners i and j, the corner itself for i = j.
    constexpr int between[4][4] = {{0, 4, 5, 6}, {4, 1, 7, 8}, {5, 7, 2, 9}, {6, 8, 9, 3}};
    // H + sum_i (x_i - x_0) (x) B_i: with B_i = grad L_i the gradient of what has the values x at the corners.
    auto plus_linear = [](Matrix H, const Lanes *x0, const Lanes *x1, const Lanes *x2, const Lanes *x3, const Lanes *B) INLINE {
        for (int k = 0; k < 3; k++) {
            const Lanes a = x1[k] - x0[k], b = x2[k] - x0[k], c = x3[k] - x0[k];
            for (int j = 0; j < 3; j++) H[k][j] += a * B[j] + b * B[3 + j] + c * B[6 + j];
        }
        return H;
    };
    // What the gradients at the four Gauss points of a quadratic element have in common; x[a] are the three components at node a.
    auto common_gradient = [&](const Lanes *const *x, const Lanes *B) INLINE {
        Lanes base[4][3];
        for (int i = 0; i < 4; i++)
            for (int k = 0; k < 3; k++) {
                Lanes edges = {};
                for (int j = 0; j < 4; j++)
                    if (j != i) edges += x[between[i][j]][k];
                base[i][k] = SELF * x[i][k] + FAR * edges;
            }
        return plus_linear(Matrix{}, base[0], base[1], base[2], base[3], B);
    };
    // The gradient at Gauss point q; `extra` is EXTRA grad L_i.
    auto gradient = [&](auto element, const Matrix &common, const Lanes *const *x, const Lanes *B, const Lanes *extra, int q) INLINE {
        if constexpr (decltype(element)::points == 1) return plus_linear(Matrix{}, x[0], x[1], x[2], x[3], B);
        else return plus_linear(common, x[between[0][q]], x[between[1][q]], x[between[2][q]], x[between[3][q]], extra);
    };
    // The gradient at corner q of a quadratic element, sum_i (4 x_between(i, q) - x_i) (x) grad L_i.
    auto corner_gradient = [&](const Lanes *const *x, const Lanes *G, int q) INLINE {
        Lanes y[4][3];
        for (int i = 0; i < 4; i++)
            for (int k = 0; k < 3; k++) y[i][k] = 4.0f * x[between[i][q]][k] - x[i][k];
        return plus_linear(Matrix{}, y[0], y[1], y[2], y[3], G);
    };
    // Nodal forces -sum_q V/points P_q grad N_a of an element, P_q = stress(q, H_q), handed to emit(node, component, force).
    auto nodal_forces = [&](auto element, const Lanes *const *x, const Lanes *G, auto stress, auto emit) INLINE {
        constexpr int points = decltype(element)::points;
        Lanes b[9], extra[9];
        for (int i = 0; i < 9; i++) b[i] = (-1.0f / points) * G[9] * G[i], extra[i] = EXTRA * G[i];
        Matrix common = {};
        if constexpr (points > 1) common = common_gradient(x, G);
        Lanes g[points][3][4];  // [q][component][corner]: -V/points P_q grad L_i, forces on the corners of a linear element
        UNROLL
        for (int q = 0; q < points; q++) {
            const Matrix P = stress(q, gradient(element, common, x, G, extra, q));
            for (int k = 0; k < 3; k++) {
                for (int i = 0; i < 3; i++) g[q][k][i + 1] = P[k][0] * b[3 * i] + P[k][1] * b[3 * i + 1] + P[k][2] * b[3 * i + 2];
                g[q][k][0] = -(g[q][k][1] + g[q][k][2] + g[q][k][3]);
            }
        }
        UNROLL
        for (int k = 0; k < 3; k++) {
            if constexpr (points == 1) {
                for (int i = 0; i < 4; i++) emit(i, k, g[0][k][i]);
            } else {
                Lanes total[4];
                for (int i = 0; i < 4; i++) total[i] = g[0][k][i] + g[1][k][i] + g[2][k][i] + g[3][k][i];
                UNROLL
                for (int i = 0; i < 4; i++) {
                    emit(i, k, SELF * total[i] + EXTRA * g[i][k][i]);
                    UNROLL
                    for (int j = i + 1; j < 4; j++) emit(between[i][j], k, FAR * (total[i] + total[j]) + EXTRA * (g[i][k][j] + g[j][k][i]));
                }
            }
        }
    };
    // Hands the element and the law of the body to work(element, law).
    auto for_the_body = [&](auto work) INLINE {
        auto of_element = [&](auto element) INLINE {
            if (scheme.law == 0) work(element, Kirchhoff{});
            else work(element, NeoHookean{});
        };
        if (body.nodes == 4) of_element(Linear{});
        else of_element(Quadratic{});
    };
"""
)

FORCES = """
    // Adds the internal forces of every block to the nodes in ascending order; if `Recorded`, keeps the running maximum of the stress
    // squared at the Gauss points and, where it is another one, at the corners.
    auto all_forces = [&](auto element, auto law, auto recorded) INLINE {
        constexpr int nodes = decltype(element)::nodes, points = decltype(element)::points;
        constexpr bool record = decltype(recorded)::record;
        Lanes *peak = (Lanes *)state.peak_squared.data, *corners = (Lanes *)state.corners_squared.data;
        auto raise = [](Lanes &highest, const Lanes now) INLINE { highest = now > highest ? now : highest; };
        for (int block = 0; block < body.blocks; block++) {
            Lanes buffer[nodes][3];
            const Lanes *x[nodes];
            load_ahead(element, block, buffer, x);
            auto stress = [&](int q, const Matrix &H) INLINE {
                const Matrix P = first_piola(law, H);
                if constexpr (record) raise(peak[points * block + q], equivalent_squared(H, P));
                return P;
            };
            if constexpr (record && points > 1) {
                for (int q = 0; q < 4; q++) {
                    const Matrix H = corner_gradient(x, geometry(block), q);
                    raise(corners[4 * block + q], equivalent_squared(H, first_piola(law, H)));
                }
            }
            add(element, block, [&](auto emit) INLINE { nodal_forces(element, x, geometry(block), stress, emit); });
        }
    };
    for_the_body([&](auto element, auto law) INLINE {
        if (record) all_forces(element, law, Recorded{});
        else all_forces(element, law, Unrecorded{});
    });
"""

STRAIN = """
    // Strain energy half a step ago and the largest stress now, lane by lane.
    DoubleLanes strain = {};
    Lanes peak = {};
    auto all_energy = [&](auto element, auto law) INLINE {
        constexpr int nodes = decltype(element)::nodes, points = decltype(element)::points;
        for (int block = 0; block < body.blocks; block++) {
            const Lanes *G = geometry(block);
            Lanes extra[9];
            for (int i = 0; i < 9; i++) extra[i] = EXTRA * G[i];
            Lanes x_buffer[nodes][3], v_buffer[nodes][3];
            const Lanes *x[nodes], *v[nodes];
            load(element, state.u.data, block, x_buffer, x);
            load(element, state.v.data, block, v_buffer, v);
            Matrix x_common = {}, v_common = {};
            if constexpr (points > 1) x_common = common_gradient(x, G), v_common = common_gradient(v, G);
            for (int q = 0; q < points; q++) {
                const Matrix H = gradient(element, x_common, x, G, extra, q), rate = gradient(element, v_common, v, G, extra, q);
                const Matrix P = first_piola(law, H);
                const Lanes now = equivalent_squared(H, P);
                const Lanes energy = G[9] * (energy_density(H) - 0.5f * scheme.time_step * contraction(P, rate)) * (1.0f / points);
                strain += __builtin_convertvector(energy, DoubleLanes);
                peak = now > peak ? now : peak;
            }
        }
    };
    for_the_body(all_energy);
"""
