// Outputs, in the quantities that all attitude filters have.
#include "attitude/ahrs/model.hpp"
#include "maths/unroll.hpp"

#include <cstring>

namespace hnav {

// The present rotation error from the errors before: theta - L dS - G db.
class AhrsModel::RotationNow {
public:
    // Since the last event the rate was constant.
    explicit RotationNow(const State& s) : P_(s.P), G_(s.x + 4), L_(&s.rate_moment) {
        if (s.x[13] == s.turned_s) return;
        std::memcpy(shown_, s.rate_moment, sizeof shown_);
        add_turn(s, shown_);
        L_ = &shown_;
    }
    RotationNow(const RotationNow&) = delete;
    RotationNow& operator=(const RotationNow&) = delete;

    Vector3R variances() const {
        Vector3R v;
        HNAV_UNROLL
        for (int k = 0; k < 3; ++k) v[k] = 2 * times(k, half_of(k)) + P_[packed(rotation + k, rotation + k)];
        return v;
    }

    Matrix3R covariance() const {
        const Half half[] = {half_of(0), half_of(1), half_of(2)};
        Matrix3R C;
        HNAV_UNROLL
        for (int k = 0; k < 3; ++k) {
            HNAV_UNROLL
            for (int i = 0; i <= k; ++i)
                C(i, k) = C(k, i) = times(i, half[k]) + times(k, half[i]) + P_[packed(rotation + i, rotation + k)];
        }
        return C;
    }

    // Rotation by bias.
    Matrix3R with_bias() const {
        const Matrix3R of_bias = bias_block(P_);
        Matrix3R C;
        for (int k = 0; k < 3; ++k)
            for (int i = 0; i < 3; ++i) {
                R sum = P_[packed(rotation + i, bias + k)];
                for (int j = 0; j < 9; ++j) sum -= L(i, j) * P_[packed(calibration + j, bias + k)];
                for (int j = 0; j < 3; ++j) sum -= G(i, j) * of_bias(j, k);
                C(i, k) = sum;
            }
        return C;
    }

    static Matrix3R bias_block(const R* P) {
        Matrix3R B;
        for (int j = 0; j < 3; ++j)
            for (int i = 0; i <= j; ++i) B(i, j) = B(j, i) = P[packed(bias + i, bias + j)];
        return B;
    }

private:
    using Pair = Eigen::Array<R, 2, 1>;

    // With a = (L, G) and p the errors of calibration and bias, the covariance is M + M' + P_theta, M = a (U a' - P_ptheta) where
    // P_pp = U + U': each pair of errors is visited once. Half is one column of the bracket; the nine calibration errors are processed
    // in pairs (SIMD), the ninth alone.
    struct Half {
        Pair of_S[4];
        R of_S8, of_b[3];
    };

    Half half_of(int k) const {
        constexpr int S8 = calibration + 8;
        const R *a = (*L_)[k], *with_theta = P_ + packed(0, rotation + k);
        Pair of_S[4];
        HNAV_UNROLL
        for (int p = 0; p < 4; ++p) of_S[p] = -Eigen::Map<const Pair>(with_theta + calibration + 2 * p);
        R of_S8 = R(0.5) * a[8] * P_[packed(S8, S8)] - with_theta[S8], of_b[3];
        HNAV_UNROLL
        for (int j = 0; j < 3; ++j) {
            const R g = G(k, j);
            HNAV_UNROLL
            for (int p = 0; p < 4; ++p) of_S[p] += g * two(calibration + 2 * p, bias + j);
            of_S8 += g * P_[packed(S8, bias + j)];
            of_b[j] = R(0.5) * g * P_[packed(bias + j, bias + j)] - P_[packed(rotation, bias + j) + k];
            HNAV_UNROLL
            for (int i = 0; i < j; ++i) of_b[i] += g * P_[packed(bias + i, bias + j)];
        }
        HNAV_UNROLL
        for (int j = 0; j < 9; ++j) {
            HNAV_UNROLL
            for (int p = 0; p < j / 2; ++p) of_S[p] += a[j] * two(calibration + 2 * p, calibration + j);
            if (j == 8) continue;
            // Down to the diagonal, which has half weight; entries below it do not belong to this column.
            const Pair last = two(calibration + j / 2 * 2, calibration + j);
            of_S[j / 2] += a[j] * (j % 2 ? Pair(1, R(0.5)) : Pair(R(0.5), 0)) * last;
        }
        return {{of_S[0], of_S[1], of_S[2], of_S[3]}, of_S8, {of_b[0], of_b[1], of_b[2]}};
    }

    R times(int i, const Half& h) const {
        const R* a = (*L_)[i];
        Pair sum = Eigen::Map<const Pair>(a) * h.of_S[0];
        HNAV_UNROLL
        for (int p = 1; p < 4; ++p) sum += Eigen::Map<const Pair>(a + 2 * p) * h.of_S[p];
        return sum[0] + sum[1] + a[8] * h.of_S8 + G(i, 0) * h.of_b[0] + G(i, 1) * h.of_b[1] + G(i, 2) * h.of_b[2];
    }

    R L(int i, int j) const { return (*L_)[i][j]; }
    R G(int i, int j) const { return G_[3 * j + i]; }
    // Elements i and i + 1 of column j.
    Pair two(int i, int j) const { return Eigen::Map<const Pair>(P_ + packed(i, j)); }

    const R* P_;
    const R* G_;
    const Moment* L_;
    Moment shown_; // at the time of x
};

Quaternion AhrsModel::attitude(const State& s) const {
    QuaternionR q = QuaternionR(s.x).normalized();
    // Predicted at the present rate.
    if (R(options_.output_latency_s) != 0) q = multiply<R>(q, rotation_quaternion<R>(rate(s) * R(options_.output_latency_s)));
    return q.cast<double>();
}

Estimate AhrsModel::estimate(const State& s) const {
    Estimate e;
    e.started = s.started != 0;
    e.rate_b = rate(s).cast<double>();
    e.bias_b = Vector3R(s.bias).cast<double>();
    e.q_bn = attitude(s);
    e.tilt_ready = e.started && tilt_ready(s);
    e.heading_ready = e.started && heading_ready(s);
    return e;
}

// Variance about each axis that is independent of the errors in P, without that of the hold.
Scalar AhrsModel::noise_now(const State& s) const {
    return rotation_noise(s) + density_.gyro_rate_psd * turn_rate(s).squaredNorm() * (s.x[13] - s.turned_s);
}

AhrsModel::Matrix3R AhrsModel::rotation_covariance(const State& s, const RotationNow& now) const {
    Matrix3R C = now.covariance();
    if (!s.started) return C;
    C.diagonal().array() += noise_now(s);
    C.diagonal() += added_variances(s);
    const Vector3R by_hold = hold_error(s);
    for (int k = 0; k < 3; ++k) C.col(k) += by_hold[k] * by_hold;
    return C;
}

// Variances about the navigation axes in addition to P. An unknown body is a vehicle as probably as not, and so has a suspected step of the
// gyro bias happened: variances of the mixtures.
Vector3Of<Scalar> AhrsModel::added_variances(const State& s) const {
    constexpr R even = R(0.5);
    const R unstated = unstated_tilt2(s);
    const R tilt = s.tilt_excess.variance + unstated + even * s.steps.suspected_tilt2 +
                   even * std::fmax(R(0), s.vehicle_tilt.square() - larger_tilt_variance(s));
    const R heading = s.steps.heading_variance_by_iron() + reference_variance(s) + unstated_heading2(s, unstated) +
                      even * (s.steps.suspected_heading2 + tilted_field_variance(s));
    return {tilt, tilt, heading};
}

Vector3Of<Scalar> AhrsModel::hold_error(const State& s) const {
    const QuaternionR q(s.x);
    const Vector3R u = turn_rate(s) - Vector3R(s.coning);
    const R interval_s = std::sqrt(s.wrong_hold + unstated_instant) * R(s.spacing_s[gyro]);
    return rotate<R>(q, u) * (interval_s / q.squaredNorm()); // whatever the length of the quaternion
}

Matrix3 AhrsModel::rotation_covariance(const State& s) const { return rotation_covariance(s, RotationNow(s)).cast<double>(); }

Vector3 AhrsModel::rotation_variances(const State& s) const {
    Vector3R v = RotationNow(s).variances();
    if (s.started) {
        v.array() += noise_now(s);
        v += added_variances(s);
        v += hold_error(s).cwiseAbs2();
    }
    return v.cast<double>();
}

Vector3 AhrsModel::bias_variances(const State& s) const {
    Vector3 v;
    for (int i = 0; i < 3; ++i) v[i] = s.P[packed(bias + i, bias + i)] + density_.bias_walk_psd * s.x[13];
    return v;
}

ErrorCovariance AhrsModel::error_covariance(const State& s) const {
    const RotationNow now(s);
    const Matrix3R rotation_bias = now.with_bias();
    Square<6, R> C;
    block<3, 3>(C, 0, 0) = rotation_covariance(s, now);
    block<3, 3>(C, 0, 3) = rotation_bias;
    block<3, 3>(C, 3, 0) = rotation_bias.transpose();
    block<3, 3>(C, 3, 3) = RotationNow::bias_block(s.P);
    diagonal<3>(C, 3).array() += density_.bias_walk_psd * s.x[13];
    return C.cast<double>();
}

FieldEstimate AhrsModel::field_estimate(const State& s) const {
    FieldEstimate f;
    f.known = s.has_reference != 0;
    f.strength_tesla = s.strength * std::hypot(s.reference[0], s.reference[1]);
    f.dip_rad = std::atan2(s.reference[1], s.reference[0]);
    f.latency_s = s.latency;
    f.latency_sigma_s = std::sqrt(honest_variances(Square<1, R>(s.P[packed(latency, latency)]))[0]);
    f.evidence_s = s.field.evidence_s;
    f.heading_trust_s = s.field.heading_trust_s;
    f.reference_changes = static_cast<int>(s.field.changes);
    switch (FieldVerdict(s.verdict)) {
    case FieldVerdict::accept: f.gate = FieldGate::accepted; break;
    case FieldVerdict::reject: f.gate = FieldGate::rejected; break;
    default: f.gate = FieldGate::inflated;
    }
    f.at_rest = s.rest.at_rest(options_);
    return f;
}

void AhrsModel::gyro_calibration(const State& s, double* S, double* sigma) const {
    Eigen::Matrix<R, 9, 1> variances;
    for (int i = 0; i < 9; ++i) variances[i] = s.P[packed(calibration + i, calibration + i)];
    variances = honest_variances(variances);
    for (int i = 0; i < 9; ++i) {
        S[i] = s.calibration[i];
        sigma[i] = std::sqrt(variances[i]);
    }
}

} // namespace hnav
