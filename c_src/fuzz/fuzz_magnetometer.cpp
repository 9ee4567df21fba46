// Magnetometer calibration on arrays of any numbers: rows of an ellipsoid with anything mixed in.
#include "input.hpp"
#include "invariant.hpp"

#include <vector>

namespace {

using fuzz::Input;

void change_options(Input& in, hnav_magnetometer_options& options) {
    double* reals[] = {&options.outlier_sigma,  &options.max_condition,           &options.max_ambiguity,  &options.min_coverage,
                       &options.max_axis_ratio, &options.max_direction_sigma_rad, &options.force_tolerance};
    switch (in.choice(4)) {
    case 0: *reals[in.choice(7)] = in.number(); break;
    case 1: options.min_samples = 13 + in.choice(32); break;
    case 2: options.robust = in.flag(); break;
    default: options.allow_hard_iron_only = in.choice(3); break;
    }
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
    Input in(bytes, size);
    const int head = in.byte();
    hnav_magnetometer_options options = hnav_magnetometer_defaults();
    for (int k = head & 3; k > 0; --k) change_options(in, options);
    double scale[3], offset[3];
    for (int i = 0; i < 3; ++i) scale[i] = head & 4 ? in.number() : 1 + 0.3 * in.fraction();
    for (int i = 0; i < 3; ++i) offset[i] = head & 8 ? in.number() : in.fraction();

    // Directions spread by the golden angle; the bytes say how each row departs from them.
    const std::size_t n = (head >> 4) * 16;
    std::vector<double> field(3 * n), force(3 * n);
    for (std::size_t k = 0; k < n; ++k) {
        const double z = 1 - (2 * k + 1.0) / n, r = std::sqrt(1 - z * z), a = 2.399963 * k;
        const double direction[3] = {r * std::cos(a), r * std::sin(a), z};
        double *m = &field[3 * k], *f = &force[3 * k];
        for (int i = 0; i < 3; ++i) {
            m[i] = scale[i] * direction[i] + offset[i];
            f[i] = 9.81 * direction[(i + 1) % 3];
        }
        if (in.end()) continue;
        switch (in.choice(8)) {
        case 0: in.vector(m, 3); break;
        case 1: in.vector(f, 3); break;
        case 2: m[0] = m[1] = m[2] = NAN; break;
        case 3: m[in.choice(3)] = in.number(); break;
        case 4:
            if (k > 0) std::memcpy(m, m - 3, 3 * sizeof *m);
            break;
        default:
            for (int i = 0; i < 3; ++i) m[i] += 0.1 * in.fraction();
            break;
        }
    }
    auto c = hnav_sized<hnav_magnetometer_calibration>();
    char message[256] = "";
    const hnav_status status =
        hnav_calibrate_magnetometer(n, field.data(), head & 8 ? nullptr : force.data(), &options, &c, message, sizeof message);
    fuzz::answered(status, message);
    if (status != HNAV_OK) return 0;
    HOLDS(fuzz::finite(c.offset, 3) && fuzz::finite(c.matrix, 9) && c.strength > 0 && std::isfinite(c.strength));
    HOLDS(c.residual_before >= 0 && c.residual_after >= 0);
    HOLDS(c.outlier_fraction >= 0 && c.outlier_fraction <= 1);
    HOLDS(c.used_samples <= c.samples && c.samples <= n && c.force_samples <= c.used_samples);
    const double* M = c.matrix;
    const double determinant =
        M[0] * (M[4] * M[8] - M[5] * M[7]) - M[1] * (M[3] * M[8] - M[5] * M[6]) + M[2] * (M[3] * M[7] - M[4] * M[6]);
    HOLDS(std::fabs(determinant - 1) < 1e-6);
    return 0;
}
