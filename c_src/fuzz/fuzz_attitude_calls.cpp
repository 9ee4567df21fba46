// The calls of an attitude filter in any order with any numbers, options included.
#include "attitude.hpp"

#include <vector>

namespace {

using fuzz::Input;

struct Sequence {
    hnav_filter* filter;
    double latest_s = 0; // the latest time that was ever named
    std::vector<unsigned char> state{};

    // A time: a step from the latest one, or any number.
    double time(Input& in) {
        const int kind = in.choice(4);
        const double t_s = kind == 3 ? in.number() : latest_s + (kind == 2 ? in.fraction() : std::fabs(in.fraction()) * 0.1);
        if (std::fabs(t_s) <= 1e12) latest_s = std::fmax(latest_s, t_s);
        return t_s;
    }

    void call(Input& in) {
        double a[3], b[3];
        hnav_status status = HNAV_OK;
        switch (in.choice(16)) {
        case 0: status = hnav_filter_push_gyro(filter, time(in), vector(in, a)); break;
        case 1: status = hnav_filter_push_accel(filter, time(in), vector(in, a)); break;
        case 2: status = hnav_filter_push_mag(filter, time(in), vector(in, a)); break;
        case 3: {
            const double t_s = time(in);
            vector(in, a);
            status = hnav_filter_push_imu(filter, t_s, a, vector(in, b));
            break;
        }
        case 4: {
            const double t_s = time(in), heading = in.number();
            status = hnav_filter_push_heading(filter, t_s, heading, in.number());
            break;
        }
        case 5:
        case 6: status = hnav_filter_advance(filter, time(in)); break;
        case 7:
        case 8: status = fuzz::push_good(filter, time(in)); break;
        case 9: status = in.flag() ? hnav_filter_realign(filter) : hnav_filter_reset(filter); break;
        case 10: state = fuzz::saved(filter); break;
        case 11: // a state of this very filter fits, whatever happened since
            if (!state.empty()) HOLDS(hnav_filter_load(filter, state.data(), state.size()) == HNAV_OK);
            break;
        case 12: run(in); break;
        case 13: hybrid(in); break;
        case 14: smooth(in); break;
        default: null_arguments(in); return;
        }
        fuzz::answered(status, hnav_filter_message(filter));
        fuzz::look(filter);
    }

    static const double* vector(Input& in, double* v) {
        in.vector(v, 3);
        return v;
    }

    struct Rows {
        std::vector<double> t_s, rate, force, field, q, euler, sigma, bias, bias_sigma, accel_nis, mag_nis;
        std::vector<std::uint8_t> ready;
        hnav_run_input input = hnav_sized<hnav_run_input>();
        hnav_run_output output = hnav_sized<hnav_run_output>();
        std::size_t n;

        Rows(Input& in, double* latest_s) : n(in.choice(12)) {
            const int present = in.byte();
            for (std::size_t k = 0; k < n; ++k) {
                const double step = in.flag() ? in.number() : 0.01;
                t_s.push_back(*latest_s + step);
                if (std::fabs(t_s.back()) <= 1e12) *latest_s = std::fmax(*latest_s, t_s.back());
                for (std::vector<double>* column : {&rate, &force, &field})
                    for (int i = 0; i < 3; ++i) column->push_back(in.flag() ? in.number() : 0.1 * (i + 1));
            }
            q.resize(4 * n);
            for (std::vector<double>* column : {&euler, &sigma, &bias, &bias_sigma}) column->resize(3 * n);
            accel_nis.resize(n);
            mag_nis.resize(n);
            ready.resize(2 * n);
            input = {sizeof input, t_s.data(), present & 1 ? rate.data() : nullptr, present & 2 ? force.data() : nullptr,
                     present & 4 ? field.data() : nullptr};
            output = {sizeof output,     q.data(),         present & 8 ? euler.data() : nullptr,    sigma.data(), bias.data(),
                      bias_sigma.data(), accel_nis.data(), present & 16 ? mag_nis.data() : nullptr, ready.data()};
        }

        void check(std::size_t rows) const {
            for (std::size_t k = 0; k < rows; ++k) HOLDS(std::isnan(q[4 * k]) || fuzz::unit(&q[4 * k]));
        }
    };

    void run(Input& in) {
        const Rows rows(in, &latest_s);
        std::size_t done = 99;
        const hnav_status status = hnav_filter_run(filter, rows.n, &rows.input, &rows.output, &done);
        fuzz::answered(status, hnav_filter_message(filter));
        if (rows.n > 0) HOLDS(status == HNAV_OK ? done == rows.n : done < rows.n);
        if (done <= rows.n) rows.check(done);
    }

    void smooth(Input& in) {
        const Rows rows(in, &latest_s);
        const hnav_status status = hnav_filter_smooth(filter, rows.n, &rows.input, &rows.output);
        fuzz::answered(status, hnav_filter_message(filter));
        if (status != HNAV_OK) return;
        rows.check(rows.n);
        for (double v : rows.q) HOLDS(std::isfinite(v)); // every row has an attitude
    }

    // What an importer of Model Exchange does: its integrator may ask at any state near the filter's, or far from it.
    void hybrid(Input& in) {
        double x[64], seed[64], out[64];
        std::int32_t nx;
        HOLDS(hnav_filter_nx(filter, &nx) == HNAV_OK && hnav_filter_get_x(filter, x) == HNAV_OK);
        const int changes = in.choice(4);
        for (int k = 0; k < changes; ++k) {
            const int i = in.choice(nx);
            x[i] = in.flag() ? in.number() : x[i] * (1 + 0.01 * in.fraction());
        }
        for (int i = 0; i < nx; ++i) seed[i] = i == changes;
        double event_s;
        HOLDS(hnav_filter_next_event_s(filter, &event_s) == HNAV_OK && !std::isnan(event_s));
        const double t_s = in.flag() && std::isfinite(event_s) ? event_s : time(in);
        hnav_status status = HNAV_OK;
        switch (in.choice(4)) {
        case 0: status = hnav_filter_derivative(filter, t_s, x, out); break;
        case 1: status = hnav_filter_derivative_along(filter, t_s, x, seed, out); break;
        case 2:
            status = hnav_filter_jump(filter, t_s, x, out);
            if (status == HNAV_OK) HOLDS(fuzz::finite(out, nx));
            break;
        default: status = hnav_filter_show(filter, t_s, x); break;
        }
        fuzz::answered(status, hnav_filter_message(filter));
    }

    void null_arguments(Input& in) {
        const auto no_input = hnav_sized<hnav_run_input>();
        const auto no_output = hnav_sized<hnav_run_output>();
        const double zero[3] = {0, 0, 0};
        hnav_status status = HNAV_OK;
        switch (in.choice(8)) {
        case 0: status = hnav_filter_push_gyro(filter, 0, nullptr); break;
        case 1: status = hnav_filter_push_imu(filter, 0, zero, nullptr); break;
        case 2: status = hnav_filter_run(filter, 3, nullptr, &no_output, nullptr); break;
        case 3: status = hnav_filter_run(filter, 3, &no_input, &no_output, nullptr); break;
        case 4: status = hnav_filter_attitude(filter, nullptr); break;
        case 5: status = hnav_filter_load(filter, nullptr, 8); break;
        case 6: status = hnav_filter_save(filter, nullptr, 8); break;
        default: status = hnav_filter_jump(filter, 0, nullptr, nullptr); break;
        }
        HOLDS(status == HNAV_ERROR_NULL_ARGUMENT);
        fuzz::answered(status, hnav_filter_message(filter));
    }
};

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
    Input in(bytes, size);
    const fuzz::Options options = fuzz::Options::from(in);
    Sequence sequence{fuzz::make(options)};
    if (!sequence.filter) return 0;
    fuzz::look(sequence.filter);
    for (int calls = 0; calls < 200 && !in.end(); ++calls) sequence.call(in);
    fuzz::takes_good_sample(sequence.filter, sequence.latest_s);
    fuzz::resets(sequence.filter, options);
    hnav_filter_destroy(sequence.filter);
    return 0;
}
