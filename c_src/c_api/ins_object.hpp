// The INS behind hnav_filter, and what its calls share.
#pragma once

#include "c_api/arrays.hpp"
#include "c_api/over_filter.hpp"
#include "c_api/sized.hpp"
#include "hnav/hnav.h"
#include "ins/model.hpp"

namespace hnav {

struct InsObject final : OverWholeFilter<OverFilter<hnav_filter, ins::Model>> {
    static constexpr Product of_product = Product::ins;
    static constexpr const char* whom = "the INS";

    InsObject() : OverWholeFilter(Product::ins) {}

    Matrix3 mounting = Matrix3::Identity(); // sensor to body axes
    double declination_rad = 0;
    bool goes_back = false; // late samples are accepted
    bool flows_outside = false; // under a caller's integrator

    // The present estimate; in a hybrid view only the motion is continuous between events, the rest is that of the last
    // event.
    hnav_navigation navigation() const;

    void destroy() override;
    void reset() override;
    hnav_status take(int sensor, double t_s, const double* value) override;
    hnav_status take_imu(double t_s, const double* rate, const double* force) override;

    hnav_status attitude(hnav_attitude* out) const override;
    hnav_status rate(double* rate_b) const override;
    hnav_status gyro_bias(double* bias_b, double* sigma) const override;
    hnav_status covariance(double* P) const override;
    hnav_status innovation(int sensor, hnav_innovation* out) const override;
    void diagnostics(hnav_diagnostics* out) const override;
    void health(hnav_health* out) const override;

    int quaternion_at() const override { return 6; } // behind displacement and velocity
    hnav_status derivative(const double* x, double* dx) const override;
    hnav_status derivative_along(const double* x, const double* seed, double* out) const override;
    Outcome jump(double t_s, const double* x_minus, double* x_plus) override;
    void show(double t_s, const double* x) override;

private:
    hnav_status push(double t_s, int channel, const double* value);
};

namespace ins_boundary {

// The channel of the model for a sensor's samples; gyroscope and accelerometer share one.
int channel_of(int sensor);
// Checks a sample of a sensor, max_values as hnav_ins_run_input has them, and turns it into body axes.
hnav_status sample_of(InsObject* object, double t_s, int channel, const double* value, ins::Sample* sample);
// The answer for a state propagated beyond its last event to now_s.
hnav_navigation navigation(const ins::Model& model, const ins::State& shown, double ahead_s, double now_s);

// Shared by recordings: checks of the arrays and of the sensor of an aid, a row of output.
hnav_status check_arrays(InsObject* object, std::size_t n, const hnav_ins_run_input* input, const hnav_ins_run_output* output);
hnav_status check_aid(const InsObject* object, const hnav_ins_run_input& input, std::size_t aid);
void fill(const ins::Navigation& from, hnav_navigation* to);
void write_row(const hnav_navigation& navigation, const hnav_ins_run_output& out, std::size_t i);

} // namespace ins_boundary
} // namespace hnav
