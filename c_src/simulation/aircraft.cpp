#include "simulation/aircraft.hpp"

#include "base/hash.hpp"

namespace hnav {

Aircraft::Aircraft(const hnav_aircraft_options& o, const hnav_aircraft_model& m) {
    flight.nx = m.nx;
    flight.nu = m.nu;
    flight.interval_s = m.interval_s;
    flight.seed = static_cast<std::uint64_t>(o.seed);
    flight.aircraft.assign(m.nx, m.nu, m.A_1_s, m.B_1_s, m.process_noise_per_sqrt_s, m.interval_s, o.exact_process_noise != 0);
    for (int i = 0; i < m.nx; ++i) {
        const auto process = [&](const hnav_gauss_markov& e) {
            return e.sigma ? GaussMarkov::over(m.interval_s, e.sigma[i], e.time_constant_s[i], o.euler_colour != 0)
                           : GaussMarkov{};
        };
        flight.accelerometer[i] = process(m.accelerometer_error);
        flight.gravity[i] = process(m.gravity_error);
        if (m.faults) flight.faults[i] = {m.faults[i].start_s, m.faults[i].stop_s, m.faults[i].factor};
        flight.measurement_sigma[i] = m.measurement_sigma[i];
        flight.start[i] = m.start ? m.start[i] : 0;
        flight.start_sigma[i] = m.start_sigma[i];
    }
    for (int j = 0; m.commands && j < m.nu; ++j)
        flight.commands[j] = {m.commands[j].amplitude, m.commands[j].period_s, m.commands[j].phase_rad};

    for (RowMajor* M : {&H_, &An_, &Qv_, &QU_, &Lambda0_, &P0_}) *M = RowMajor::Zero(m.nx, m.nx);
    for (int i = 0; i < m.nx; ++i) {
        const GaussMarkov& error = flight.accelerometer[i];
        H_(i, i) = 1;
        An_(i, i) = error.phi;
        Qv_(i, i) = flight.measurement_sigma[i] * flight.measurement_sigma[i];
        QU_(i, i) = error.drive_variance();
        Lambda0_(i, i) = error.sigma * error.sigma;
        P0_(i, i) = flight.start_sigma[i] * flight.start_sigma[i];
    }
    flight.reset();
}

bool Aircraft::is_finite() const {
    const LinearAircraft& a = flight.aircraft;
    return a.A.allFinite() && a.B.allFinite() && a.factor.allFinite();
}

std::uint64_t Aircraft::fingerprint() const {
    const AircraftFlight& f = flight;
    std::uint64_t h = hash(&f.interval_s, sizeof f.interval_s);
    h = hash(&f.seed, sizeof f.seed, h);
    for (const RowMajor* M : {&f.aircraft.A, &f.aircraft.B, &f.aircraft.factor, &An_, &Qv_, &Lambda0_, &P0_})
        h = hash(M->data(), M->size() * sizeof(double), h);
    h = hash(f.gravity, f.nx * sizeof *f.gravity, h);
    h = hash(f.faults, f.nx * sizeof *f.faults, h);
    h = hash(f.start, f.nx * sizeof *f.start, h);
    return hash(f.commands, f.nu * sizeof *f.commands, h);
}

hnav_ins_error_model Aircraft::filter_model() const {
    hnav_ins_error_model model{};
    model.nx = model.nz = model.nw = model.nl = flight.nx;
    model.nu = flight.nu;
    model.A = flight.aircraft.A.data();
    model.B = flight.nu > 0 ? flight.aircraft.B.data() : nullptr;
    model.Qw = flight.aircraft.Qw.data();
    model.H = H_.data();
    model.An = An_.data();
    model.Qv = Qv_.data();
    model.QU = QU_.data();
    model.Lambda0 = Lambda0_.data();
    model.x0 = flight.start;
    model.P0 = P0_.data();
    return model;
}

} // namespace hnav
