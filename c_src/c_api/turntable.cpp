// The C boundary of the turntable.
#include "simulation/turntable.hpp"

#include "base/memory.hpp"
#include "c_api/arrays.hpp"
#include "c_api/sized.hpp"
#include "options/lists.hpp"

#include <cmath>

using hnav::Quaternion;
using hnav::Vector3;

struct hnav_turntable : hnav::KeptMessage<160> {
    hnav::TurntableMotion motion;
};

namespace {

void store(const hnav::Truth& from, double t_s, hnav_truth* truth) {
    truth->t_s = t_s;
    hnav::store(from.q, truth->q_nb);
    hnav::store(hnav::roll_pitch_yaw(from.q), truth->euler_rad);
    hnav::store(from.rate, truth->rate_b_rad_s);
    hnav::store(from.force, truth->force_b_m_s2);
    hnav::store(from.field, truth->field_b_tesla);
}

} // namespace

extern "C" {

hnav_status hnav_turntable_create(hnav_turntable** table, const hnav_turntable_options* options, char* message,
                                  size_t message_size) {
    const hnav::CallersMessage caller{message, message_size};
    if (const hnav_status status = caller.begin(table, "table", {{options, "options"}})) return status;
    if (const hnav_status status = caller.check_options(options, hnav::turntable_options)) return status;
    const hnav::TurntableMotion motion = hnav::turntable_of(*options);
    for (int i = 0; i < 3; ++i) {
        const hnav::AxisMotion& axis = motion.axes[i];
        constexpr const char* names[] = {"roll", "pitch", "yaw"};
        if (axis.has_corners() && !(axis.quarter_s() >= axis.corners_apart_s))
            return caller.fail(HNAV_ERROR_OPTION,
                               "%s.amplitude_rad = %g at %s.rate_rad_s = %g is over in %g s: at least %g s are needed", names[i],
                               axis.amplitude_rad, names[i], axis.rate_rad_s, axis.quarter_s(), axis.corners_apart_s);
    }
    auto* self = hnav::make_object<hnav_turntable>();
    if (!self) return caller.fail(HNAV_ERROR_OUT_OF_MEMORY, "no memory for the turntable");
    self->motion = motion;
    *table = self;
    return HNAV_OK;
}

void hnav_turntable_destroy(hnav_turntable* table) { hnav::destroy_object(table); }

const char* hnav_turntable_message(const hnav_turntable* table) { return table ? table->message : "table is null"; }

hnav_status hnav_turntable_at(const hnav_turntable* table, double t_s, hnav_truth* truth) {
    return hnav_turntable_in_piece(table, t_s, t_s, truth);
}

hnav_status hnav_turntable_in_piece(const hnav_turntable* table, double piece_s, double t_s, hnav_truth* truth) {
    REQUIRE_STRUCT(table, truth, hnav_truth);
    REQUIRE_FINITE(table, t_s);
    REQUIRE_FINITE(table, piece_s);
    hnav_truth result{};
    store(table->motion.at(t_s, table->motion.pieces(piece_s)), t_s, &result);
    return hnav::hand_out(result, truth);
}

hnav_status hnav_turntable_next_corner_s(const hnav_turntable* table, double t_s, double* corner_s) {
    REQUIRE(table, corner_s);
    REQUIRE_FINITE(table, t_s);
    *corner_s = table->motion.next_corner_s(t_s);
    return HNAV_OK;
}

hnav_status hnav_turntable_seen_from(const hnav_turntable* table, const double* q_nb, double* force_b_m_s2,
                                     double* field_b_tesla) {
    REQUIRE(table, q_nb);
    REQUIRE(table, force_b_m_s2);
    REQUIRE(table, field_b_tesla);
    const double length = Quaternion(q_nb).norm();
    if (!std::isfinite(length)) return table->fail(HNAV_ERROR_NON_FINITE, "q_nb is not finite, or its length is not");
    if (!(length > 1e-150)) return table->fail(HNAV_ERROR_ZERO_VECTOR, "q_nb has length %g, which is no attitude", length);
    hnav::Truth truth;
    truth.q = Quaternion(q_nb) / length;
    table->motion.see(&truth);
    hnav::store(truth.force, force_b_m_s2);
    hnav::store(truth.field, field_b_tesla);
    return HNAV_OK;
}

hnav_status hnav_quaternion_to_euler_along(const double* q_nb, const double* dq_nb, double* along_rad) {
    if (!q_nb || !dq_nb || !along_rad) return HNAV_ERROR_NULL_ARGUMENT;
    hnav::store(hnav::roll_pitch_yaw_along(Quaternion(q_nb), Quaternion(dq_nb)), along_rad);
    return HNAV_OK;
}

hnav_status hnav_quaternion_to_euler(const double* q_nb, double* euler_rad) {
    if (!q_nb || !euler_rad) return HNAV_ERROR_NULL_ARGUMENT;
    hnav::store(hnav::roll_pitch_yaw(Quaternion(q_nb)), euler_rad);
    return HNAV_OK;
}

hnav_status hnav_quaternion_derivative(const double* q_nb, const double* rate_b_rad_s, double* derivative_1_s) {
    if (!q_nb || !rate_b_rad_s || !derivative_1_s) return HNAV_ERROR_NULL_ARGUMENT;
    hnav::store(Quaternion(hnav::Xi(Quaternion(q_nb)) * Vector3(rate_b_rad_s)), derivative_1_s);
    return HNAV_OK;
}

} // extern "C"
