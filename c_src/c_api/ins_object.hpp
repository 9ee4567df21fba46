// The object behind hnav_ins, and what its calls share.
#pragma once

#include "c_api/message.hpp"
#include "c_api/sized.hpp"
#include "hnav/hnav.h"
#include "hybrid/filter.hpp"
#include "ins/model.hpp"

struct hnav_ins : hnav::KeptMessage<320> {
    hnav::Filter<hnav::ins::Model> filter;
    hnav::Matrix3 mounting = hnav::Matrix3::Identity(); // sensor to body axes
    double declination_rad = 0;
    bool goes_back = false; // late samples are taken
    bool flows_outside = false; // by an integrator of the caller's
};

namespace hnav::ins_boundary {

// Checks a sample of a sensor, six values as hnav_ins_run_input has them, and turns it into body axes.
hnav_status sample_of(hnav_ins* object, double t_s, int sensor, const double* value, ins::Sample* sample);
// The same, and puts it into the queue.
hnav_status push(hnav_ins* object, double t_s, int sensor, const double* value);
hnav_status push_imu(hnav_ins* object, double t_s, const double* rate, const double* force);
hnav_status check_time(const hnav_ins* object, double t_s);
hnav_status advance(hnav_ins* object, double t_s);
// Of a state that has been brought so far beyond its last event, to now_s.
hnav_navigation navigation(const ins::Model& model, const ins::State& shown, double ahead_s, double now_s);

// What recordings share: a row of rate and force that is missing, arrays that are there, a row of the answer.
bool is_missing(const double* v);
hnav_status check_arrays(hnav_ins* object, std::size_t n, const hnav_ins_run_input* input, const hnav_ins_run_output* output);
void write_row(const hnav_navigation& navigation, const hnav_ins_run_output& out, std::size_t i);

} // namespace hnav::ins_boundary
