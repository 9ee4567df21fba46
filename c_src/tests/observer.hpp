// Shared by the tests of the observer: the arguments of create, and an observer with short accessors.
#pragma once

#include "hnav/hnav.h"

#include <gtest/gtest.h>
#include <Eigen/Dense>

#include <string>
#include <vector>

namespace hnav::test {

using Numbers = std::vector<double>;
using Bytes = std::vector<unsigned char>;

// The arguments of create, with numbers that live as long.
struct Given {
    hnav_plant plant = hnav_sized<hnav_plant>();
    hnav_observer_options options = hnav_observer_defaults();
    Numbers start, start_sigma, noise, nominal, ready_sigma, time_constant, sensor_sigma, gate_nis;
    Bytes logarithmic;

    hnav_observer_statistics known() const {
        auto k = hnav_sized<hnav_observer_statistics>();
        const auto data = [](const Numbers& n) { return n.empty() ? nullptr : n.data(); };
        k.start = data(start);
        k.start_sigma = data(start_sigma);
        k.noise = data(noise);
        k.nominal = data(nominal);
        k.ready_sigma = data(ready_sigma);
        k.time_constant_s = data(time_constant);
        k.sensor_sigma = data(sensor_sigma);
        k.gate_nis = data(gate_nis);
        k.logarithmic = logarithmic.empty() ? nullptr : logarithmic.data();
        return k;
    }

    // The message of a refusal, "" for none.
    std::string refusal(hnav_status expected) const {
        char message[320] = "";
        hnav_filter* o = nullptr;
        const auto k = known();
        EXPECT_EQ(hnav_observer_create(&o, &options, &plant, &k, message, sizeof message), expected) << message;
        hnav_filter_destroy(o);
        return message;
    }
};

class Observer {
public:
    explicit Observer(const Given& given) {
        char message[320] = "";
        const auto known = given.known();
        EXPECT_EQ(hnav_observer_create(&o_, &given.options, &given.plant, &known, message, sizeof message), HNAV_OK) << message;
        N_ = info().n_estimated;
    }
    Observer(const Observer&) = delete;
    Observer& operator=(const Observer&) = delete;
    ~Observer() { hnav_filter_destroy(o_); }

    operator hnav_filter*() const { return o_; }
    hnav_observer_info info() const {
        auto info = hnav_sized<hnav_observer_info>();
        EXPECT_EQ(hnav_observer_get_info(o_, &info), HNAV_OK);
        return info;
    }
    Numbers x() const {
        Numbers x(N_);
        EXPECT_EQ(hnav_observer_estimate(o_, x.data(), nullptr), HNAV_OK);
        return x;
    }
    Numbers sigma() const {
        Numbers sigma(N_);
        EXPECT_EQ(hnav_observer_estimate(o_, nullptr, sigma.data()), HNAV_OK);
        return sigma;
    }
    Numbers P() const {
        Numbers P(N_ * N_);
        EXPECT_EQ(hnav_filter_covariance(o_, P.data()), HNAV_OK);
        return P;
    }
    // e' P^-1 e
    double nees(const Numbers& truth) const {
        const Numbers x = this->x(), P = this->P();
        Eigen::VectorXd e(N_);
        for (int i = 0; i < N_; ++i) e[i] = x[i] - truth[i];
        return e.dot(Eigen::Map<const Eigen::MatrixXd>(P.data(), N_, N_).ldlt().solve(e));
    }
    hnav_observer_innovation_of innovation(int sensor) const {
        auto out = hnav_sized<hnav_observer_innovation_of>();
        EXPECT_EQ(hnav_observer_innovation(o_, sensor, &out), HNAV_OK);
        return out;
    }
    // An element of the newest innovation of a sensor; 0 before its first sample.
    template <class Field>
    double number_of(int sensor, Field&& field) const {
        auto out = hnav_sized<hnav_observer_innovation_of>();
        return hnav_observer_innovation(o_, sensor, &out) == HNAV_OK ? field(out) : 0;
    }
    hnav_observer_block_proof proof(hnav_plant_block block) const {
        auto out = hnav_sized<hnav_observer_block_proof>();
        EXPECT_EQ(hnav_observer_proof(o_, block, &out), HNAV_OK);
        return out;
    }
    Bytes saved() const {
        size_t bytes = 0;
        EXPECT_EQ(hnav_filter_state_size(o_, &bytes), HNAV_OK);
        Bytes state(bytes);
        EXPECT_EQ(hnav_filter_save(o_, state.data(), bytes), HNAV_OK);
        return state;
    }
    std::string message() const { return hnav_filter_message(o_); }

private:
    hnav_filter* o_ = nullptr;
    int N_ = 0;
};

} // namespace hnav::test
