// The C boundary of the turntable.
#include "c_api/message.hpp"
#include "hnav/simulation.h"
#include "options/lists.hpp"
#include "simulation/motion.hpp"
#include "simulation/random.hpp"
#include "simulation/streams.hpp"

#include <cstdlib>
#include <new>

using hnav::Quaternion;
using hnav::Vector3;

struct hnav_turntable {
    hnav::TurntableMotion motion;
};

namespace {

hnav::AxisMotion axis_of(const hnav_axis_options& o, double chance) {
    hnav::AxisMotion axis;
    axis.kind = static_cast<hnav::Motion>(o.motion);
    axis.angle_rad = o.angle_rad + o.unknown_rad * (2 * chance - 1);
    axis.amplitude_rad = o.amplitude_rad;
    axis.rate_rad_s = o.rate_rad_s;
    axis.period_s = o.period_s;
    axis.start_s = o.start_s;
    return axis;
}

void store(const hnav::Truth& from, double t_s, hnav_truth* truth) {
    truth->t_s = t_s;
    const Vector3 euler = hnav::roll_pitch_yaw(from.q);
    for (int i = 0; i < 4; ++i) truth->q_nb[i] = from.q[i];
    for (int i = 0; i < 3; ++i) {
        truth->euler_rad[i] = euler[i];
        truth->rate_b_rad_s[i] = from.rate[i];
        truth->force_b_m_s2[i] = from.force[i];
        truth->field_b_tesla[i] = from.field[i];
    }
}

} // namespace

extern "C" {

hnav_status hnav_turntable_create(hnav_turntable** table, const hnav_turntable_options* options, char* message,
                                  size_t message_size) {
    const hnav::CallersMessage caller{message, message_size};
    caller.clear();
    if (!table) return caller.fail(HNAV_ERROR_NULL_ARGUMENT, "table is null");
    *table = nullptr;
    if (!options) return caller.fail(HNAV_ERROR_NULL_ARGUMENT, "options is null");
    const hnav_status status = caller.check_options(options, hnav::turntable_options);
    if (status != HNAV_OK) return status;
    void* memory = std::malloc(sizeof(hnav_turntable));
    if (!memory) return caller.fail(HNAV_ERROR_OUT_OF_MEMORY, "no memory for the turntable");
    auto* self = new (memory) hnav_turntable;
    const hnav::RandomStream random(static_cast<std::uint64_t>(options->seed), hnav::streams::turntable);
    const hnav_axis_options* axes[] = {&options->roll, &options->pitch, &options->yaw};
    for (int i = 0; i < 3; ++i) self->motion.axes[i] = axis_of(*axes[i], random.uniform(static_cast<std::uint64_t>(i)));
    self->motion.force_n = {0, 0, -options->gravity_m_s2};
    const double dip = options->field_dip_rad, declination = options->declination_rad;
    self->motion.field_n = options->field_strength_tesla *
                           Vector3(std::cos(dip) * std::cos(declination), std::cos(dip) * std::sin(declination), std::sin(dip));
    *table = self;
    return HNAV_OK;
}

void hnav_turntable_destroy(hnav_turntable* table) { std::free(table); }

hnav_status hnav_turntable_at(const hnav_turntable* table, double t_s, hnav_truth* truth) {
    return hnav_turntable_in_piece(table, t_s, t_s, truth);
}

hnav_status hnav_turntable_in_piece(const hnav_turntable* table, double piece_s, double t_s, hnav_truth* truth) {
    if (!table || !truth) return HNAV_ERROR_NULL_ARGUMENT;
    if (!std::isfinite(t_s) || !std::isfinite(piece_s)) return HNAV_ERROR_NON_FINITE;
    store(table->motion.at(t_s, table->motion.pieces(piece_s)), t_s, truth);
    return HNAV_OK;
}

hnav_status hnav_turntable_next_corner_s(const hnav_turntable* table, double t_s, double* corner_s) {
    if (!table || !corner_s) return HNAV_ERROR_NULL_ARGUMENT;
    if (!std::isfinite(t_s)) return HNAV_ERROR_NON_FINITE;
    *corner_s = table->motion.next_corner_s(t_s);
    return HNAV_OK;
}

hnav_status hnav_turntable_seen_from(const hnav_turntable* table, const double* q_nb, double* force_b_m_s2,
                                     double* field_b_tesla) {
    if (!table || !q_nb || !force_b_m_s2 || !field_b_tesla) return HNAV_ERROR_NULL_ARGUMENT;
    const double length = Quaternion(q_nb).norm();
    if (!std::isfinite(length)) return HNAV_ERROR_NON_FINITE;
    if (!(length > 1e-150)) return HNAV_ERROR_ZERO_VECTOR;
    hnav::Truth truth;
    truth.q = Quaternion(q_nb) / length;
    table->motion.see(&truth);
    for (int i = 0; i < 3; ++i) {
        force_b_m_s2[i] = truth.force[i];
        field_b_tesla[i] = truth.field[i];
    }
    return HNAV_OK;
}

hnav_status hnav_quaternion_to_euler(const double* q_nb, double* euler_rad) {
    if (!q_nb || !euler_rad) return HNAV_ERROR_NULL_ARGUMENT;
    Eigen::Map<Vector3>{euler_rad} = hnav::roll_pitch_yaw(Quaternion(q_nb));
    return HNAV_OK;
}

hnav_status hnav_quaternion_derivative(const double* q_nb, const double* rate_b_rad_s, double* derivative_1_s) {
    if (!q_nb || !rate_b_rad_s || !derivative_1_s) return HNAV_ERROR_NULL_ARGUMENT;
    const Quaternion derivative = hnav::Xi(Quaternion(q_nb)) * Vector3(rate_b_rad_s);
    Eigen::Map<Quaternion>{derivative_1_s} = derivative;
    return HNAV_OK;
}

} // extern "C"
