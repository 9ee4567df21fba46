// A flight: the true aircraft, the coloured errors of its INS, and the readings of the INS.
//
//   z(k) = x(k) + lambda(k) + v(k),   lambda = accelerometer error + gravity error, each Gauss-Markov
//
// Every channel of the INS reads one state. Each source of noise is a stream of random.hpp, and number k n + i of it
// belongs to sample k and channel i, so a flight is a function of the seed and the commands only.
#pragma once

#include "simulation/gauss_markov.hpp"
#include "simulation/linear_aircraft.hpp"
#include "simulation/noise_fault.hpp"
#include "simulation/random.hpp"
#include "simulation/square_wave.hpp"

#include <cstring>

namespace hnav {

class AircraftFlight {
public:
    // Numbers 0 to n - 1 of the process noise are those of the start state.
    enum Stream : std::uint64_t { process_noise = 1000, measurement_noise, accelerometer_noise, gravity_noise };

    // Numbers only: what a saved flight holds.
    struct State {
        double k;
        double x[max_dimension];
        double accelerometer[max_dimension], gravity[max_dimension];
        double z[max_dimension];
        double u[max_dimension]; // held up to sample k
    };

    int nx = 0, nu = 0;
    double interval_s = 0;
    std::uint64_t seed = 0;
    LinearAircraft aircraft;
    GaussMarkov accelerometer[max_dimension], gravity[max_dimension];
    NoiseFault faults[max_dimension];
    SquareWave commands[max_dimension];
    double measurement_sigma[max_dimension] = {};
    double start[max_dimension] = {}, start_sigma[max_dimension] = {};

    State state{};

    // To sample 0.
    void reset() {
        state = {};
        for (int i = 0; i < nx; ++i) {
            state.x[i] = start[i] + start_sigma[i] * number(process_noise, i);
            state.accelerometer[i] = accelerometer[i].start(number(accelerometer_noise, i));
            state.gravity[i] = gravity[i].start(number(gravity_noise, i));
        }
        read();
    }

    // To the next sample; command (nu, null for none) is held meanwhile and adds to the square waves.
    void step(const double* command) {
        const double t_s = time_s();
        for (int j = 0; j < nu; ++j) state.u[j] = commands[j].at(t_s) + (command ? command[j] : 0);
        state.k += 1;
        double x[max_dimension], n[max_dimension];
        for (int i = 0; i < nx; ++i) n[i] = number(process_noise, i);
        for (int i = 0; i < nx; ++i) {
            x[i] = 0;
            for (int j = 0; j < nx; ++j) x[i] += aircraft.A(i, j) * state.x[j];
            for (int j = 0; j < nu; ++j) x[i] += aircraft.B(i, j) * state.u[j];
            for (int j = 0; j <= i; ++j) x[i] += aircraft.factor(i, j) * n[j];
        }
        std::memcpy(state.x, x, nx * sizeof(double));
        for (int i = 0; i < nx; ++i) {
            state.accelerometer[i] = accelerometer[i].next(state.accelerometer[i], number(accelerometer_noise, i));
            state.gravity[i] = gravity[i].next(state.gravity[i], number(gravity_noise, i));
        }
        read();
    }

    double time_s() const { return state.k * interval_s; }
    double lambda(int i) const { return state.accelerometer[i] + state.gravity[i]; }
    double noise_factor(int i) const { return faults[i].factor_at(state.k, interval_s); }

private:
    double number(Stream stream, int channel) const {
        return RandomStream(seed, stream).normal(static_cast<std::uint64_t>(state.k) * nx + channel);
    }

    void read() {
        for (int i = 0; i < nx; ++i)
            state.z[i] = state.x[i] + lambda(i) + noise_factor(i) * measurement_sigma[i] * number(measurement_noise, i);
    }
};

} // namespace hnav
