// Vectors of SUNDIALS. Its serial vector has its length at run time and allocates for fused operations; for states of a few
// dozen numbers that costs more than the arithmetic. Ours has its length at compile time (0: at run time), with its numbers
// in the memory reserved for the solver. It also has the number of elements that the flow reads: a stage of a Runge-Kutta
// method, which is passed to the flow only, has no others.
#include "hybrid/sundials_vector.hpp"

#include "hybrid/sundials_memory.h"
#include "maths/unroll.hpp"

#include <cmath>
#include <cstdint>
#include <cstring>

namespace hnav::sundials {
namespace {

// The content of a vector: the number of elements, then the elements.
std::int64_t* count_before(N_Vector v) { return static_cast<std::int64_t*>(v->content) - 1; }

template <int N, int read = N>
struct Vector {
    static int size(N_Vector v) { return N ? N : static_cast<int>(*count_before(v)); }

    static length get_length(N_Vector v) { return size(v); }
    static double* get_data(N_Vector v) { return data(v); }
    static N_Vector_ID id(N_Vector) { return SUNDIALS_NVEC_CUSTOM; }

    static N_Vector clone(N_Vector like) {
        N_Vector v = make(size(like), like->sunctx);
        if (!v) return nullptr;
        if (N_VCopyOps(like, v) == 0) return v;
        destroy(v);
        return nullptr;
    }
    static void destroy(N_Vector v) {
        if (!v) return;
        if (v->content) hnav_sundials_free(count_before(v));
        N_VFreeEmpty(v);
    }

    static void linear_sum(real a, N_Vector x, real b, N_Vector y, N_Vector z) {
        for (int i = 0; i < size(z); ++i) data(z)[i] = a * data(x)[i] + b * data(y)[i];
    }
    static void constant(real c, N_Vector z) {
        for (int i = 0; i < size(z); ++i) data(z)[i] = c;
    }
    static void product(N_Vector x, N_Vector y, N_Vector z) {
        for (int i = 0; i < size(z); ++i) data(z)[i] = data(x)[i] * data(y)[i];
    }
    static void quotient(N_Vector x, N_Vector y, N_Vector z) {
        for (int i = 0; i < size(z); ++i) data(z)[i] = data(x)[i] / data(y)[i];
    }
    static void scale(real c, N_Vector x, N_Vector z) {
        const double* X = data(x);
        double* Z = data(z);
        if (c == 1) { // a copy, the most frequent call
            if (X != Z) std::memcpy(Z, X, size(z) * sizeof(double));
            return;
        }
        for (int i = 0; i < size(z); ++i) Z[i] = c * X[i];
    }
    static void absolute(N_Vector x, N_Vector z) {
        for (int i = 0; i < size(z); ++i) data(z)[i] = std::fabs(data(x)[i]);
    }
    static void inverse(N_Vector x, N_Vector z) {
        for (int i = 0; i < size(z); ++i) data(z)[i] = 1 / data(x)[i];
    }
    static void add_constant(N_Vector x, real b, N_Vector z) {
        for (int i = 0; i < size(z); ++i) data(z)[i] = data(x)[i] + b;
    }
    static real dot(N_Vector x, N_Vector y) {
        const double *X = data(x), *Y = data(y);
        double sum = 0;
        for (int i = 0; i < size(x); ++i) sum += X[i] * Y[i];
        return sum;
    }
    static real max_norm(N_Vector x) {
        const double* X = data(x);
        double max = 0;
        for (int i = 0; i < size(x); ++i) max = std::fmax(max, std::fabs(X[i]));
        return max;
    }
    static real weighted_rms(N_Vector x, N_Vector w) {
        const double *X = data(x), *W = data(w);
        double sum = 0;
        for (int i = 0; i < size(x); ++i) sum += X[i] * W[i] * X[i] * W[i];
        return std::sqrt(sum / size(x));
    }
    static real minimum(N_Vector x) {
        const double* X = data(x);
        double min = X[0];
        for (int i = 1; i < size(x); ++i) min = std::fmin(min, X[i]);
        return min;
    }
    // z = sum of c_k x_k in one pass; every Runge-Kutta stage is one such sum. It goes in pieces whose sums the compiler keeps
    // in registers, term by term; a term whose coefficient is zero, as some of a method's are, is left out.
    // NOLINTNEXTLINE(readability-non-const-parameter): its type is given
    static int linear_combination(int count, real* c, N_Vector* x, N_Vector z) {
        constexpr int piece = 24, small_piece = 4; // 24: twelve registers of two
        // The solution of a step is the sum of one slope per stage and of its beginning, its error that of the slopes alone,
        // with one more if there is one; a stage has fewer terms.
        if constexpr (read < N) {
            if (count <= stages_of_equal_steps) return stage(count, c, x, z);
        }
        int i = 0;
        for (; i + piece <= size(z); i += piece) combine<piece>(count, c, x, z, i);
        if constexpr (N != 0) {
            if constexpr (N % piece != 0) combine<N % piece>(count, c, x, z, i);
        } else {
            for (; i + small_piece <= size(z); i += small_piece) combine<small_piece>(count, c, x, z, i);
            for (; i < size(z); ++i) combine<1>(count, c, x, z, i);
        }
        return 0;
    }

    // The same for the elements that are read, without a loop.
    static int stage(int count, const real* c, const N_Vector* x, N_Vector z) {
        switch (count) {
        case 2: return combine_all<2>(c, x, z);
        case 3: return combine_all<3>(c, x, z);
        case 4: return combine_all<4>(c, x, z);
        case 5: return combine_all<5>(c, x, z);
        case 6: return combine_all<6>(c, x, z);
        default: combine<read>(count, c, x, z, 0); return 0;
        }
    }

    template <int count>
    static int combine_all(const real* c, const N_Vector* x, N_Vector z) {
        double sum[read];
        for (int i = 0; i < read; ++i) sum[i] = c[0] * data(x[0])[i];
        HNAV_UNROLL
        for (int k = 1; k < count; ++k)
            for (int i = 0; i < read; ++i) sum[i] += c[k] * data(x[k])[i];
        for (int i = 0; i < read; ++i) data(z)[i] = sum[i];
        return 0;
    }

    template <int n>
    static void combine(int count, const real* c, const N_Vector* x, N_Vector z, int begin) {
        double sum[n];
        const double* first = data(x[0]) + begin;
        for (int i = 0; i < n; ++i) sum[i] = c[0] * first[i];
        for (int k = 1; k < count; ++k) {
            const double ck = c[k];
            if (ck == 0) continue;
            const double* X = data(x[k]) + begin;
            for (int i = 0; i < n; ++i) sum[i] += ck * X[i];
        }
        for (int i = 0; i < n; ++i) data(z)[begin + i] = sum[i];
    }

    // Zeros, in one piece with the content.
    static N_Vector make(int n, SUNContext context) {
        N_Vector v = N_VNewEmpty(context);
        if (!v) return nullptr;
        auto* piece = static_cast<std::int64_t*>(hnav_sundials_calloc(1, sizeof(std::int64_t) + n * sizeof(double)));
        if (!piece) {
            N_VFreeEmpty(v);
            return nullptr;
        }
        *piece = n;
        v->content = piece + 1;
        return v;
    }

    static N_Vector create(int n, SUNContext context) {
        N_Vector v = make(n, context);
        if (!v) return nullptr;
        N_Vector_Ops ops = v->ops;
        ops->nvgetvectorid = id;
        ops->nvclone = clone;
        ops->nvdestroy = destroy;
        ops->nvgetlength = get_length;
        ops->nvgetarraypointer = get_data;
        ops->nvlinearsum = linear_sum;
        ops->nvconst = constant;
        ops->nvprod = product;
        ops->nvdiv = quotient;
        ops->nvscale = scale;
        ops->nvabs = absolute;
        ops->nvinv = inverse;
        ops->nvaddconst = add_constant;
        ops->nvdotprod = dot;
        ops->nvmaxnorm = max_norm;
        ops->nvwrmsnorm = weighted_rms;
        ops->nvmin = minimum;
        ops->nvlinearcombination = linear_combination;
        return v;
    }
};

} // namespace

// Lengths of most filters, and the general one.
N_Vector create_vector(int n, int read, SUNContext context) {
    switch (n) {
    case 10: return Vector<10>::create(n, context); // observer of two states, a transition matrix and noise
    case 14: // AHRS and HREKF: q, the integral of its rotation matrix, a clock
        return read == 4 ? Vector<14, 4>::create(n, context) : Vector<14>::create(n, context);
    default: return Vector<0>::create(n, context);
    }
}

} // namespace hnav::sundials
