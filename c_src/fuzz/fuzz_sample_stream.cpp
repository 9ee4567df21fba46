// A stream of samples as broken hardware sends it: times that jump, repeat and run back, values that freeze, spike and
// vanish. Options are the defaults. Afterwards five seconds of good samples must bring the filter back.
#include "attitude.hpp"

#include <memory>

namespace {

using fuzz::Input;

struct Stream {
    double t_s = 0, latest_s = 0;
    double rate[3] = {0, 0, 0}, force[3] = {0, 0, -9.81}, field[3] = {2e-5, 0, 4e-5};

    void step_time(Input& in) {
        switch (in.choice(8)) {
        case 0: break;                                              // the same instant again
        case 1: t_s -= std::fabs(in.fraction()); break;             // late
        case 2: t_s += 100 * std::fabs(in.fraction()); break;       // a gap
        case 3: t_s = latest_s + std::fabs(in.fraction()) * 1e-9; break; // hardly later
        case 4: {
            const double any = in.number(); // a clock that starts elsewhere
            t_s = std::fabs(any) < 1e9 ? any : t_s;
            break;
        }
        default: t_s += 0.01; break;
        }
        latest_s = std::fmax(latest_s, t_s);
    }

    void disturb(Input& in, double* v, double size) {
        switch (in.choice(6)) {
        case 0: in.vector(v, 3); break;
        case 1: v[in.choice(3)] = in.number(); break;
        case 2: v[in.choice(3)] += size * in.fraction(); break;
        case 3:
            for (int i = 0; i < 3; ++i) v[i] = size * in.fraction();
            break;
        default: break; // frozen
        }
    }
};

// The estimate of a body at rest with samples of push_good: its tilt is that of the force.
void recovers(hnav_filter* filter, double latest_s) {
    double t_s = latest_s;
    int sent = 0;
    for (; sent < 500; ++sent) {
        t_s += 0.01;
        fuzz::enters(filter, t_s - 0.01, t_s);
        hnav_filter_advance(filter, t_s);
        if (sent == 0) HOLDS(hnav_filter_advance(filter, t_s) == HNAV_OK); // what could not be used has been dropped
    }
    auto attitude = hnav_sized<hnav_attitude>();
    HOLDS(hnav_filter_attitude(filter, &attitude) == HNAV_OK);
    fuzz::look(filter);
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
    Input in(bytes, size);
    fuzz::Options options;
    const int head = in.byte();
    options.ahrs = head & 1;
    options.hrekf_options = hnav_hrekf_defaults(head & 2 ? HNAV_PRESET_PAPER : HNAV_PRESET_DEFAULT);
    options.ahrs_options = hnav_ahrs_defaults(HNAV_PRESET_DEFAULT);
    options.hrekf_options.queue_capacity = options.ahrs_options.queue_capacity = 32;
    options.hrekf_options.horizon_s = options.ahrs_options.horizon_s = head & 4 ? 0.2 : 0;
    hnav_filter* filter = fuzz::make(options);
    HOLDS(filter);

    Stream s;
    for (int k = 0; k < 100 && !in.end(); ++k) {
        s.step_time(in);
        const int what = in.byte();
        if (what & 1) s.disturb(in, s.rate, 5);
        if (what & 2) s.disturb(in, s.force, 20);
        if (what & 4) s.disturb(in, s.field, 1e-4);
        hnav_status status = HNAV_OK;
        if (what & 8) status = hnav_filter_push_imu(filter, s.t_s, s.rate, s.force);
        fuzz::answered(status, hnav_filter_message(filter));
        if (what & 16) status = hnav_filter_push_mag(filter, s.t_s, s.field);
        fuzz::answered(status, hnav_filter_message(filter));
        if ((what & 0xe0) == 0xe0) status = hnav_filter_push_heading(filter, s.t_s, s.rate[0], std::fabs(s.rate[1]));
        fuzz::answered(status, hnav_filter_message(filter));
        if ((what & 0x60) != 0x60) continue; // let some wait
        fuzz::answered(hnav_filter_advance(filter, s.t_s), hnav_filter_message(filter));
        fuzz::look(filter);
    }
    recovers(filter, s.latest_s);
    hnav_filter_destroy(filter);
    return 0;
}
