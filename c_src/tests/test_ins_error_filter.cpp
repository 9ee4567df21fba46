// The filter for coloured INS errors through the C API: laws that relate the forms, every refusal, and the heap.
#include "hnav/hnav.h"

#include "counted_heap.hpp"
#include "maths/modes.hpp"

#include <Eigen/LU>

#include <gtest/gtest.h>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <vector>

namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();
using Row = Eigen::RowVectorXd;
using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// A damped oscillator beside a slow state, all three measured; time constant of the errors 100 steps.
struct Model {
    Square A{3, 3}, B{3, 1}, H = Square::Identity(3, 3), An = 0.99 * Square::Identity(3, 3), Qw{3, 3}, Qv{3, 3}, QU{3, 3},
                             Lambda0{3, 3}, P0 = Square::Identity(3, 3);
    double x0[3] = {0.1, -0.2, 0.3};
    bool coloured = true;

    explicit Model(double v = 1) {
        A << 0.95, 0.3, 0, -0.3, 0.9, 0.1, 0, 0, 0.8;
        B << 0.1, 0.5, 0;
        Qw = Eigen::Vector3d(0.02, 0.05, 0.1).asDiagonal();
        Qv = (v * Eigen::Vector3d(0.5, 0.2, 0.1)).asDiagonal();
        Lambda0 = Eigen::Vector3d(2, 1, 0.5).asDiagonal();
        QU = Lambda0 * (1 - 0.99 * 0.99);
    }

    hnav_ins_error_model view() const {
        auto m = hnav_sized<hnav_ins_error_model>();
        m.nx = m.nz = 3;
        m.nu = 1;
        m.A = A.data();
        m.B = B.data();
        m.H = H.data();
        m.An = coloured ? An.data() : nullptr;
        m.Qw = Qw.data();
        m.Qv = Qv.data();
        m.QU = QU.data();
        m.Lambda0 = Lambda0.data();
        m.P0 = P0.data();
        m.x0 = x0;
        return m;
    }
};

struct Data {
    std::vector<double> u, z;
};

// Samples of the model; `factor` on the sigma of v in channel 1 from step `from` to `to`.
Data samples(const Model& m, int steps, unsigned seed, double factor = 1, int from = 0, int to = 0) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    const auto draw = [&](const Square& Q) {
        Eigen::Vector3d r;
        for (int i = 0; i < 3; ++i) r[i] = std::sqrt(Q(i, i)) * normal(random);
        return r;
    };
    Eigen::Vector3d x = Eigen::Vector3d(m.x0) + draw(m.P0), lambda = m.coloured ? draw(m.Lambda0) : Eigen::Vector3d::Zero();
    Data d;
    for (int k = 0; k < steps; ++k) {
        const double u = std::sin(0.05 * k);
        if (k > 0) {
            x = m.A * x + m.B * u + draw(m.Qw);
            if (m.coloured) lambda = m.An * lambda + draw(m.QU);
        }
        Eigen::Vector3d v = draw(m.Qv);
        if (k >= from && k < to) v[1] *= factor;
        const Eigen::Vector3d z = m.H * x + lambda + v;
        d.u.push_back(u);
        d.z.insert(d.z.end(), z.data(), z.data() + 3);
    }
    return d;
}

hnav_ins_error_options options_of(hnav_ins_error_form form, hnav_noise_scaling scaling = HNAV_NOISE_SCALING_NONE) {
    hnav_ins_error_options o = hnav_ins_error_defaults();
    o.form = form;
    o.noise_scaling = scaling;
    return o;
}

// Probabilities.
struct Faults {
    Eigen::Vector3d noise, bias;
    double process = 0;
};

// Owns a filter; calls that a test does not expect to fail must succeed.
class Handle {
public:
    Handle(const Model& model, const hnav_ins_error_options& options) : Handle(model.view(), options) {}
    Handle(const hnav_ins_error_model& model, const hnav_ins_error_options& options) {
        char message[320];
        EXPECT_EQ(hnav_ins_error_filter_create(&filter_, &options, &model, message, sizeof message), HNAV_OK) << message;
    }
    Handle(const Handle&) = delete;
    ~Handle() { hnav_ins_error_filter_destroy(filter_); }
    operator hnav_ins_error_filter*() const { return filter_; }

    void step(const Data& d, int k) {
        ASSERT_EQ(hnav_ins_error_filter_step(filter_, &d.u[k], &d.z[3 * k], nullptr), HNAV_OK)
            << hnav_ins_error_filter_message(filter_);
    }
    Eigen::Vector3d x() const {
        Eigen::Vector3d x;
        EXPECT_EQ(hnav_ins_error_filter_estimate(filter_, x.data(), nullptr), HNAV_OK);
        return x;
    }
    Square P() const {
        Square P(3, 3);
        EXPECT_EQ(hnav_ins_error_filter_covariance(filter_, P.data()), HNAV_OK);
        return P;
    }
    Eigen::Vector3d innovation() const {
        Eigen::Vector3d nu;
        EXPECT_EQ(hnav_ins_error_filter_innovation(filter_, nu.data(), nullptr, nullptr), HNAV_OK);
        return nu;
    }
    Eigen::Vector3d fault_probability() const {
        Eigen::Vector3d p;
        EXPECT_EQ(hnav_ins_error_filter_noise(filter_, nullptr, p.data()), HNAV_OK);
        return p;
    }

    Faults faults() const {
        Faults p;
        EXPECT_EQ(hnav_ins_error_filter_faults(filter_, p.noise.data(), p.bias.data(), &p.process), HNAV_OK);
        return p;
    }

private:
    hnav_ins_error_filter* filter_ = nullptr;
};

// Largest absolute lag-one correlation of the innovations over the channels, in standard deviations of white ones.
double colour_of_innovations(const Model& m, hnav_ins_error_form form) {
    const int steps = 6000, settled = 500;
    const Data d = samples(m, steps, 11);
    Handle f(m, options_of(form));
    Eigen::Array3d product = Eigen::Array3d::Zero(), square = Eigen::Array3d::Zero(), before = Eigen::Array3d::Zero();
    for (int k = 0; k < steps; ++k) {
        f.step(d, k);
        const Eigen::Array3d nu = f.innovation();
        if (k > settled) {
            product += nu * before;
            square += nu * nu;
        }
        before = nu;
    }
    return (product / square).abs().maxCoeff() * std::sqrt(steps - settled);
}

} // namespace

// ------------------------------------------------------------------------------------------------ laws

TEST(InsErrorFilter, WithoutColourTheAugmentedFormIsTheKalmanFilter) {
    Model m;
    m.coloured = false;
    const Data d = samples(m, 200, 1);
    Handle f(m, options_of(HNAV_INS_ERROR_AUGMENTED));
    Eigen::VectorXd x = Eigen::Vector3d(m.x0);
    Square P = m.P0;
    for (int k = 0; k < 200; ++k) {
        f.step(d, k);
        if (k > 0) {
            x = m.A * x + m.B * d.u[k];
            P = (m.A * P * m.A.transpose() + m.Qw).eval();
        }
        const Square S = m.H * P * m.H.transpose() + m.Qv;
        const Square K = P * m.H.transpose() * S.inverse();
        x += K * (Eigen::Vector3d(&d.z[3 * k]) - m.H * x);
        P = ((Square::Identity(3, 3) - K * m.H) * P).eval();
        ASSERT_LT((f.x() - x).norm(), 1e-12);
        ASSERT_LT((f.P() - P).norm(), 1e-12);
    }
}

TEST(InsErrorFilter, WithoutWhiteNoiseTheDifferencedFormIsTheAugmentedOne) {
    const Model m(0);
    const Data d = samples(m, 500, 2);
    for (const int lag : {0, 1}) {
        hnav_ins_error_options o = options_of(HNAV_INS_ERROR_DIFFERENCED), p = options_of(HNAV_INS_ERROR_AUGMENTED);
        o.lag = p.lag = lag;
        Handle differenced(m, o), augmented(m, p);
        for (int k = 0; k < 500; ++k) {
            differenced.step(d, k);
            augmented.step(d, k);
            ASSERT_LT((differenced.x() - augmented.x()).norm(), 1e-9) << "step " << k << ", lag " << lag;
            ASSERT_LT((differenced.P() - augmented.P()).norm(), 1e-9) << "step " << k << ", lag " << lag;
            Eigen::Vector3d lambda[2], sigma[2];
            ASSERT_EQ(hnav_ins_error_filter_coloured_error(differenced, lambda[0].data(), sigma[0].data(), nullptr), HNAV_OK);
            ASSERT_EQ(hnav_ins_error_filter_coloured_error(augmented, lambda[1].data(), sigma[1].data(), nullptr), HNAV_OK);
            ASSERT_LT((lambda[0] - lambda[1]).norm() + (sigma[0] - sigma[1]).norm(), 1e-7) << "step " << k << ", lag " << lag;
        }
    }
}

TEST(InsErrorFilter, ChannelAfterChannelIsAllAtOnce) {
    Model m;
    const Data d = samples(m, 300, 3);
    Handle sequential(m, options_of(HNAV_INS_ERROR_AUGMENTED));
    m.Qv(0, 1) = m.Qv(1, 0) = 1e-200; // no longer diagonal, and the same for all counted values
    Handle joint(m, options_of(HNAV_INS_ERROR_AUGMENTED));
    hnav_ins_error_options short_form = options_of(HNAV_INS_ERROR_AUGMENTED);
    short_form.joseph = 0;
    Handle joint_short(m, short_form);
    for (int k = 0; k < 300; ++k) {
        for (Handle* f : {&sequential, &joint, &joint_short}) f->step(d, k);
        ASSERT_LT((sequential.x() - joint.x()).norm(), 1e-11);
        ASSERT_LT((sequential.P() - joint.P()).norm(), 1e-11);
        ASSERT_LT((sequential.P() - joint_short.P()).norm(), 1e-10);
    }
}

TEST(InsErrorFilter, TheCovarianceStaysOneOver20000Steps) {
    const Model m(1e-6); // little noise, so that rounding could make P indefinite
    const Data d = samples(m, 20000, 4, 30, 5000, 6000);
    for (const hnav_ins_error_form form : {HNAV_INS_ERROR_AUGMENTED, HNAV_INS_ERROR_DIFFERENCED, HNAV_INS_ERROR_PLAIN})
        for (const int lag : {0, 1}) {
            hnav_ins_error_options o = options_of(form, HNAV_NOISE_SCALING_JOINT);
            o.lag = lag;
            Handle f(m, o);
            double least = infinity;
            for (int k = 0; k < 20000; ++k) {
                f.step(d, k);
                const Square P = f.P();
                ASSERT_EQ((P - P.transpose()).norm(), 0);
                const Eigen::Vector3d sigma = P.diagonal().cwiseSqrt();
                const Square correlation = sigma.cwiseInverse().asDiagonal() * P * sigma.cwiseInverse().asDiagonal();
                if (k % 10 == 0) least = std::fmin(least, hnav::symmetric_eigenvalues(correlation, nullptr)[0]);
            }
            EXPECT_GT(least, 0) << "form " << form << ", lag " << lag;
        }
}

TEST(InsErrorFilter, LookingBackOneStepIsSurer) {
    const Model m;
    const Data d = samples(m, 100, 5);
    for (const hnav_ins_error_form form : {HNAV_INS_ERROR_AUGMENTED, HNAV_INS_ERROR_DIFFERENCED, HNAV_INS_ERROR_PLAIN}) {
        hnav_ins_error_options o = options_of(form);
        Handle now(m, o);
        o.lag = 1;
        Handle before(m, o);
        Square P = m.P0;
        for (int k = 0; k < 100; ++k) {
            before.step(d, k);
            const double gained = k > 0 ? hnav::symmetric_eigenvalues(P - before.P(), nullptr)[0] : 0;
            EXPECT_GE(gained, -1e-12) << "form " << form;
            now.step(d, k);
            P = now.P();
            auto info = hnav_sized<hnav_ins_error_info>();
            ASSERT_EQ(hnav_ins_error_filter_info(before, &info), HNAV_OK);
            EXPECT_EQ(info.shown_step, std::uint64_t(k > 0 ? k - 1 : 0));
        }
    }
}

TEST(InsErrorFilter, StatementOneOfThePaperHoldsWithoutWhiteNoiseOnly) {
    EXPECT_LT(colour_of_innovations(Model(0), HNAV_INS_ERROR_DIFFERENCED), 4);
    EXPECT_GT(colour_of_innovations(Model(1), HNAV_INS_ERROR_MDKF), 10);
    EXPECT_GT(colour_of_innovations(Model(1), HNAV_INS_ERROR_DIFFERENCED), 10);
    EXPECT_LT(colour_of_innovations(Model(1), HNAV_INS_ERROR_AUGMENTED), 4); // the optimal filter's innovations are white
}

TEST(InsErrorFilter, AFaultyChannelIsFoundAndForgiven) {
    const Model m;
    const Data d = samples(m, 400, 6, 8, 150, 250);
    for (const hnav_noise_scaling scaling : {HNAV_NOISE_SCALING_HMM, HNAV_NOISE_SCALING_JOINT}) {
        Handle f(m, options_of(HNAV_INS_ERROR_AUGMENTED, scaling));
        for (int k = 0; k < 400; ++k) {
            f.step(d, k);
            const Eigen::Vector3d p = f.fault_probability();
            EXPECT_LT(std::fmax(p[0], p[2]), 0.5) << "step " << k;
            if (k < 150 || k >= 350) {
                EXPECT_LT(p[1], 0.5) << "step " << k;
            }
            if (k >= 160 && k < 250) {
                EXPECT_GT(p[1], 0.5) << "step " << k;
            }
        }
    }
}

TEST(InsErrorFilter, AnErrorThatJumpsIsABiasFaultAndIsLearned) {
    const Model m;
    Data d = samples(m, 300, 21);
    const double jump = 10 * std::sqrt(m.Qv(1, 1));
    for (int k = 150; k < 300; ++k) d.z[3 * k + 1] += jump;
    Handle f(m, options_of(HNAV_INS_ERROR_AUGMENTED, HNAV_NOISE_SCALING_JOINT));
    double found = 0, before = 0;
    for (int k = 0; k < 300; ++k) {
        f.step(d, k);
        const Faults p = f.faults();
        EXPECT_LT(std::fmax(p.bias[0], p.bias[2]), 0.5) << "step " << k;
        if (k < 150) {
            EXPECT_LT(p.bias[1], 0.5) << "step " << k;
        } else if (k < 165) {
            found = std::fmax(found, p.bias[1]);
        } else {
            EXPECT_LT(p.noise.maxCoeff(), 0.5) << "step " << k;
        }
        double lambda[3];
        ASSERT_EQ(hnav_ins_error_filter_coloured_error(f, lambda, nullptr, nullptr), HNAV_OK);
        if (k == 149) before = lambda[1];
        if (k == 170) {
            EXPECT_NEAR(lambda[1] - before, jump, 0.4 * jump);
        }
    }
    EXPECT_GT(found, 0.9);
    EXPECT_LT(f.faults().bias[1], 0.05); // the jump is learned, then forgotten
}

TEST(InsErrorFilter, ALivelierProcessIsNoFaultOfChannels) {
    Model truth;
    truth.Qw *= 9;
    const int steps = 2000;
    const Data d = samples(truth, steps, 22);
    double flagged[2] = {}, lively = 0;
    for (const hnav_noise_scaling scaling : {HNAV_NOISE_SCALING_HMM, HNAV_NOISE_SCALING_JOINT}) {
        Handle f(Model(), options_of(HNAV_INS_ERROR_AUGMENTED, scaling));
        for (int k = 0; k < steps; ++k) {
            f.step(d, k);
            const Faults p = f.faults();
            const bool joint = scaling == HNAV_NOISE_SCALING_JOINT;
            flagged[joint] += (p.noise.array() > 0.5).count() / (3.0 * steps);
            lively += joint && p.process > 0.5;
        }
    }
    EXPECT_GT(flagged[0], 0.05);
    EXPECT_LT(flagged[1], 0.01);
    EXPECT_GT(lively, 0.9 * steps);
}

TEST(InsErrorFilter, JointHypothesesThatAreAllButImpossibleChangeNothing) {
    const Model m;
    const Data d = samples(m, 200, 23);
    for (const int lag : {0, 1}) {
        hnav_ins_error_options o = options_of(HNAV_INS_ERROR_AUGMENTED, HNAV_NOISE_SCALING_JOINT);
        o.joint_fault_probability = 1e-15;
        o.joint_outlier_probability = o.joint_bias_probability = 0;
        o.joint_process_probability = o.joint_common_probability = 0;
        o.lag = lag;
        Handle joint(m, o);
        o.noise_scaling = HNAV_NOISE_SCALING_NONE;
        Handle none(m, o);
        for (int k = 0; k < 200; ++k) {
            joint.step(d, k);
            none.step(d, k);
            ASSERT_LT((joint.x() - none.x()).norm(), 1e-9) << "step " << k << ", lag " << lag;
            ASSERT_LT((joint.P() - none.P()).norm(), 1e-9) << "step " << k << ", lag " << lag;
        }
    }
}

TEST(InsErrorFilter, WithoutLambdaJointIsTheHiddenMarkovChain) {
    const Model m;
    const Data d = samples(m, 200, 24, 8, 80, 150);
    for (const hnav_ins_error_form form : {HNAV_INS_ERROR_DIFFERENCED, HNAV_INS_ERROR_PLAIN}) {
        Handle joint(m, options_of(form, HNAV_NOISE_SCALING_JOINT)), hmm(m, options_of(form, HNAV_NOISE_SCALING_HMM));
        for (int k = 0; k < 200; ++k) {
            joint.step(d, k);
            hmm.step(d, k);
            ASSERT_EQ(joint.x(), hmm.x()) << "step " << k << ", form " << form;
            ASSERT_EQ(joint.faults().noise, hmm.fault_probability());
            ASSERT_EQ(joint.faults().bias, Eigen::Vector3d(0, 0, 0));
            ASSERT_EQ(joint.faults().process, 0);
        }
    }
}

TEST(InsErrorFilter, AStepWithoutAnyChannelIsAPrediction) {
    const Model m;
    const Data d = samples(m, 20, 7);
    const double nothing[3] = {not_a_number, not_a_number, not_a_number};
    const std::uint8_t absent[3] = {0, 0, 0};
    for (const hnav_ins_error_form form : {HNAV_INS_ERROR_AUGMENTED, HNAV_INS_ERROR_DIFFERENCED, HNAV_INS_ERROR_PLAIN}) {
        Handle f(m, options_of(form)), masked(m, options_of(form));
        for (int k = 0; k < 10; ++k) {
            f.step(d, k);
            masked.step(d, k);
        }
        const Eigen::Vector3d x = m.A * f.x() + m.B * d.u[10];
        const Square P = m.A * f.P() * m.A.transpose() + m.Qw;
        ASSERT_EQ(hnav_ins_error_filter_step(f, &d.u[10], nothing, nullptr), HNAV_OK);
        ASSERT_EQ(hnav_ins_error_filter_step(masked, &d.u[10], &d.z[30], absent), HNAV_OK);
        EXPECT_LT((f.x() - x).norm(), 1e-14);
        EXPECT_LT((f.P() - P).norm(), 1e-14);
        EXPECT_EQ(f.x(), masked.x());
        double nis;
        ASSERT_EQ(hnav_ins_error_filter_innovation(f, nullptr, nullptr, &nis), HNAV_OK);
        EXPECT_TRUE(std::isnan(nis));
    }
}

TEST(InsErrorFilter, AModeThatNoMeasurementShowsIsNotHeldAgainstTheModel) {
    Model m;
    m.A(1, 2) = 0; // the oscillator alone
    const auto separability = [](const Model& model) {
        double value = -1;
        Handle f(model, options_of(HNAV_INS_ERROR_AUGMENTED));
        EXPECT_EQ(hnav_ins_error_filter_separability(f, &value), HNAV_OK);
        return value;
    };
    m.A(2, 2) = 0.2; // far from An
    const double seen = separability(m);
    EXPECT_GT(seen, 0.1);
    m.H(2, 2) = 0; // and now the third state is not
    EXPECT_GE(separability(m), seen - 1e-12);
    m.H(2, 2) = 1;
    m.A(2, 2) = 0.99; // equal to An: modes with the same dynamics cannot be distinguished
    EXPECT_LT(separability(m), 1e-6);
}

TEST(InsErrorFilter, ContinuousMatricesAreDiscretisedExactly) {
    Model continuous;
    continuous.A << -0.5, 3, 0, -3, -1, 1, 0, 0, -2;
    continuous.An = -Square::Identity(3, 3) / 60;
    continuous.QU = continuous.Lambda0 * 2 / 60;
    hnav_ins_error_model m = continuous.view();
    m.interval_s = 0.1;
    Handle f(m, options_of(HNAV_INS_ERROR_AUGMENTED));
    m.Lambda0 = nullptr; // the stationary covariance, which is the same
    Handle stationary(m, options_of(HNAV_INS_ERROR_AUGMENTED));
    const Data d = samples(Model(), 50, 8);
    for (int k = 0; k < 50; ++k) {
        f.step(d, k);
        stationary.step(d, k);
        ASSERT_LT((f.x() - stationary.x()).norm(), 1e-12);
    }
    double lambda_sigma[3];
    Handle fresh(m, options_of(HNAV_INS_ERROR_AUGMENTED));
    ASSERT_EQ(hnav_ins_error_filter_coloured_error(fresh, nullptr, lambda_sigma, nullptr), HNAV_OK);
    EXPECT_NEAR(lambda_sigma[0], std::sqrt(2.0), 1e-12);
}

// ------------------------------------------------------------------------------------------------ save and load

TEST(InsErrorFilter, SaveWreckLoadGoesOnBitForBit) {
    const Model m;
    const Data d = samples(m, 120, 9, 8, 50, 90), other = samples(m, 120, 10);
    for (int form = HNAV_INS_ERROR_MDKF; form <= HNAV_INS_ERROR_PLAIN; ++form)
        for (int scaling = HNAV_NOISE_SCALING_NONE; scaling <= HNAV_NOISE_SCALING_JOINT; ++scaling) {
            hnav_ins_error_options o = options_of(hnav_ins_error_form(form), hnav_noise_scaling(scaling));
            o.lag = scaling % 2;
            Handle f(m, o);
            size_t bytes;
            ASSERT_EQ(hnav_ins_error_filter_state_size(f, &bytes), HNAV_OK);
            std::vector<unsigned char> middle(bytes), end(bytes), again(bytes);
            for (int k = 0; k < 60; ++k) f.step(d, k);
            ASSERT_EQ(hnav_ins_error_filter_save(f, middle.data(), bytes), HNAV_OK);
            for (int k = 60; k < 120; ++k) f.step(d, k);
            ASSERT_EQ(hnav_ins_error_filter_save(f, end.data(), bytes), HNAV_OK);
            for (int k = 0; k < 120; ++k) f.step(other, k);
            ASSERT_EQ(hnav_ins_error_filter_load(f, middle.data(), bytes), HNAV_OK);
            for (int k = 60; k < 120; ++k) f.step(d, k);
            ASSERT_EQ(hnav_ins_error_filter_save(f, again.data(), bytes), HNAV_OK);
            EXPECT_EQ(end, again) << "form " << form << ", scaling " << scaling;
        }
}

TEST(InsErrorFilter, ADamagedStateIsRefusedAndChangesNothing) {
    const Model m;
    const Data d = samples(m, 10, 12);
    Handle f(m, options_of(HNAV_INS_ERROR_AUGMENTED));
    for (int k = 0; k < 10; ++k) f.step(d, k);
    size_t bytes;
    ASSERT_EQ(hnav_ins_error_filter_state_size(f, &bytes), HNAV_OK);
    std::vector<unsigned char> saved(bytes);
    ASSERT_EQ(hnav_ins_error_filter_save(f, saved.data(), bytes), HNAV_OK);
    const Eigen::Vector3d x = f.x();
    EXPECT_EQ(hnav_ins_error_filter_save(f, saved.data(), bytes - 1), HNAV_ERROR_SIZE);
    EXPECT_EQ(hnav_ins_error_filter_load(f, saved.data(), bytes - 1), HNAV_ERROR_SIZE);
    for (const size_t place : {size_t(0), size_t(9), size_t(17), bytes - 3}) {
        saved[place] ^= 1;
        EXPECT_EQ(hnav_ins_error_filter_load(f, saved.data(), bytes), HNAV_ERROR_STATE_CORRUPT) << "byte " << place;
        saved[place] ^= 1;
    }
    Model other;
    other.A(0, 0) = 0.94;
    Handle g(other, options_of(HNAV_INS_ERROR_AUGMENTED));
    EXPECT_EQ(hnav_ins_error_filter_load(g, saved.data(), bytes), HNAV_ERROR_STATE_CORRUPT);
    EXPECT_EQ(f.x(), x);
}

// ------------------------------------------------------------------------------------------------ refusals

TEST(InsErrorFilter, EveryImpossibleModelIsRefusedByName) {
    struct Wrong {
        hnav_status status;
        const char* text;
        std::function<void(Model&, hnav_ins_error_model&)> spoil;
    };
    const std::vector<Wrong> cases = {
        {HNAV_ERROR_SIZE, "nx = 0", [](Model&, hnav_ins_error_model& m) { m.nx = 0; }},
        {HNAV_ERROR_SIZE, "nx = 33", [](Model&, hnav_ins_error_model& m) { m.nx = 33; }},
        {HNAV_ERROR_SIZE, "nu = -1", [](Model&, hnav_ins_error_model& m) { m.nu = -1; }},
        {HNAV_ERROR_SIZE, "nz = 33", [](Model&, hnav_ins_error_model& m) { m.nz = 33; }},
        {HNAV_ERROR_SIZE, "nw = 2 without G", [](Model&, hnav_ins_error_model& m) { m.nw = 2; }},
        {HNAV_ERROR_SIZE, "nw = 33", [](Model&, hnav_ins_error_model& m) { m.nw = 33, m.G = m.A; }},
        {HNAV_ERROR_SIZE, "nl = 2 without Bn", [](Model&, hnav_ins_error_model& m) { m.nl = 2; }},
        {HNAV_ERROR_SIZE, "nl = 0", [](Model&, hnav_ins_error_model& m) { m.Bn = m.A; }},
        {HNAV_ERROR_OPTION, "interval_s = -1", [](Model&, hnav_ins_error_model& m) { m.interval_s = -1; }},
        {HNAV_ERROR_OPTION, "A over interval_s", [](Model& s, hnav_ins_error_model& m) { s.A(0, 0) = 1e6, m.interval_s = 1; }},
        {HNAV_ERROR_NULL_ARGUMENT, "A is null", [](Model&, hnav_ins_error_model& m) { m.A = nullptr; }},
        {HNAV_ERROR_NULL_ARGUMENT, "B is null", [](Model&, hnav_ins_error_model& m) { m.B = nullptr; }},
        {HNAV_ERROR_NULL_ARGUMENT, "H is null", [](Model&, hnav_ins_error_model& m) { m.H = nullptr; }},
        {HNAV_ERROR_NULL_ARGUMENT, "Qw is null", [](Model&, hnav_ins_error_model& m) { m.Qw = nullptr; }},
        {HNAV_ERROR_NULL_ARGUMENT, "Qv is null", [](Model&, hnav_ins_error_model& m) { m.Qv = nullptr; }},
        {HNAV_ERROR_NULL_ARGUMENT, "QU is null", [](Model&, hnav_ins_error_model& m) { m.QU = nullptr; }},
        {HNAV_ERROR_NULL_ARGUMENT, "P0 is null", [](Model&, hnav_ins_error_model& m) { m.P0 = nullptr; }},
        {HNAV_ERROR_NON_FINITE, "A[1][2]", [](Model& s, hnav_ins_error_model&) { s.A(1, 2) = not_a_number; }},
        {HNAV_ERROR_NON_FINITE, "B[0][0]", [](Model& s, hnav_ins_error_model&) { s.B(0, 0) = infinity; }},
        {HNAV_ERROR_NON_FINITE, "H[2][0]", [](Model& s, hnav_ins_error_model&) { s.H(2, 0) = not_a_number; }},
        {HNAV_ERROR_NON_FINITE, "An[0][1]", [](Model& s, hnav_ins_error_model&) { s.An(0, 1) = not_a_number; }},
        {HNAV_ERROR_NON_FINITE, "x0[1]", [](Model& s, hnav_ins_error_model&) { s.x0[1] = not_a_number; }},
        {HNAV_ERROR_NON_FINITE, "Lambda0[1][1]", [](Model& s, hnav_ins_error_model&) { s.Lambda0(1, 1) = not_a_number; }},
        {HNAV_ERROR_OPTION, "Qw is not symmetric", [](Model& s, hnav_ins_error_model&) { s.Qw(0, 1) = 0.01; }},
        {HNAV_ERROR_OPTION, "P0 is not symmetric", [](Model& s, hnav_ins_error_model&) { s.P0(2, 1) = 0.5; }},
        {HNAV_ERROR_OPTION, "Qv is not positive semidefinite: Qv[2][2] = -1",
         [](Model& s, hnav_ins_error_model&) { s.Qv(2, 2) = -1; }},
        {HNAV_ERROR_OPTION, "QU is not positive semidefinite: QU[0][1] = 9",
         [](Model& s, hnav_ins_error_model&) { s.QU(0, 1) = s.QU(1, 0) = 9; }},
        {HNAV_ERROR_OPTION, "P0 is not positive semidefinite: an eigenvalue",
         [](Model& s, hnav_ins_error_model&) { s.P0 << 1, 0.9, 0.9, 0.9, 1, -0.9, 0.9, -0.9, 1; }},
        {HNAV_ERROR_OPTION, "An is unstable", [](Model& s, hnav_ins_error_model&) { s.An(0, 0) = 1.01; }},
        {HNAV_ERROR_OPTION, "Lambda0 is null", [](Model& s, hnav_ins_error_model& m) { s.An(0, 0) = 1, m.Lambda0 = nullptr; }},
        {HNAV_ERROR_OPTION, "A has an unstable mode that H",
         [](Model& s, hnav_ins_error_model&) { s.A(2, 2) = 1.1, s.A(1, 2) = 0, s.H(2, 2) = 0; }},
        {HNAV_ERROR_OPTION, "Qv[0][1] = 0.01: noise_scaling needs a diagonal Qv",
         [](Model& s, hnav_ins_error_model&) { s.Qv(0, 1) = s.Qv(1, 0) = 0.01; }},
    };
    const hnav_ins_error_options options = hnav_ins_error_defaults();
    for (const Wrong& wrong : cases) {
        Model m;
        hnav_ins_error_model view = m.view();
        wrong.spoil(m, view);
        char message[320];
        hnav_ins_error_filter* filter;
        EXPECT_EQ(hnav_ins_error_filter_create(&filter, &options, &view, message, sizeof message), wrong.status) << wrong.text;
        EXPECT_EQ(filter, nullptr);
        EXPECT_NE(std::string(message).find(wrong.text), std::string::npos)
            << "\"" << message << "\" without \"" << wrong.text << "\"";
    }
}

TEST(InsErrorFilter, AModelThatReplacesIsCheckedAlike) {
    const Model m;
    Handle f(m, hnav_ins_error_defaults());
    Model wrong;
    wrong.Qw(1, 1) = -1;
    hnav_ins_error_model view = wrong.view();
    EXPECT_EQ(hnav_ins_error_filter_replace_model(f, &view), HNAV_ERROR_OPTION);
    EXPECT_NE(std::string(hnav_ins_error_filter_message(f)).find("Qw"), std::string::npos);
    view = m.view();
    view.nu = 0;
    EXPECT_EQ(hnav_ins_error_filter_replace_model(f, &view), HNAV_ERROR_SIZE);
    EXPECT_EQ(hnav_ins_error_filter_replace_model(f, nullptr), HNAV_ERROR_NULL_ARGUMENT);
    const Data d = samples(m, 30, 13);
    Handle untouched(m, hnav_ins_error_defaults());
    for (int k = 0; k < 30; ++k) {
        f.step(d, k);
        untouched.step(d, k);
    }
    EXPECT_EQ(f.x(), untouched.x());
}

TEST(InsErrorFilter, EveryImpossibleOptionIsRefusedByName) {
    const Model m;
    const hnav_ins_error_model view = m.view();
    char message[320];
    hnav_ins_error_filter* filter;
    for (int32_t i = 0; hnav_option("ins_error", i); ++i) {
        const hnav_option_info* row = hnav_option("ins_error", i);
        hnav_ins_error_options o = hnav_ins_error_defaults();
        char* field = reinterpret_cast<char*>(&o) + row->offset;
        if (row->kind == HNAV_OPTION_REAL) {
            const double value = not_a_number;
            std::memcpy(field, &value, sizeof value);
        } else {
            const int32_t value = -1;
            std::memcpy(field, &value, sizeof value);
        }
        EXPECT_EQ(hnav_ins_error_filter_create(&filter, &o, &view, message, sizeof message), HNAV_ERROR_OPTION) << row->name;
        EXPECT_EQ(std::string(message).find(row->name), 0u) << message;
    }
    hnav_ins_error_options o = hnav_ins_error_defaults();
    o.stamp = 0;
    EXPECT_EQ(hnav_ins_error_filter_create(&filter, &o, &view, message, sizeof message), HNAV_ERROR_OPTIONS_STAMP);
    EXPECT_EQ(hnav_ins_error_filter_create(&filter, nullptr, &view, nullptr, 0), HNAV_ERROR_NULL_ARGUMENT);
    o = hnav_ins_error_defaults();
    EXPECT_EQ(hnav_ins_error_filter_create(&filter, &o, nullptr, nullptr, 0), HNAV_ERROR_NULL_ARGUMENT);
    EXPECT_EQ(hnav_ins_error_filter_create(nullptr, &o, &view, nullptr, 0), HNAV_ERROR_NULL_ARGUMENT);
}

TEST(InsErrorFilter, AFailedStepLeavesTheEstimateAsItWas) {
    const Model m;
    const Data d = samples(m, 30, 14);
    Handle f(m, options_of(HNAV_INS_ERROR_AUGMENTED, HNAV_NOISE_SCALING_JOINT)),
        untouched(m, options_of(HNAV_INS_ERROR_AUGMENTED, HNAV_NOISE_SCALING_JOINT));
    double nis;
    EXPECT_EQ(hnav_ins_error_filter_innovation(f, nullptr, nullptr, &nis), HNAV_ERROR_NO_DATA);
    const double bad[3] = {0, infinity, 0}, huge[3] = {1e200, 0, 0}, bad_u = not_a_number;
    for (int k = 0; k < 30; ++k) {
        f.step(d, k);
        untouched.step(d, k);
        EXPECT_EQ(hnav_ins_error_filter_step(f, &d.u[k], bad, nullptr), HNAV_ERROR_NON_FINITE);
        EXPECT_NE(std::string(hnav_ins_error_filter_message(f)).find("z[1]"), std::string::npos);
        EXPECT_EQ(hnav_ins_error_filter_step(f, &bad_u, &d.z[0], nullptr), HNAV_ERROR_NON_FINITE);
        EXPECT_NE(std::string(hnav_ins_error_filter_message(f)).find("u[0]"), std::string::npos);
        EXPECT_EQ(hnav_ins_error_filter_step(f, &d.u[k], huge, nullptr), HNAV_ERROR_SOLVER);
        EXPECT_EQ(hnav_ins_error_filter_step(f, nullptr, &d.z[0], nullptr), HNAV_ERROR_NULL_ARGUMENT);
        EXPECT_EQ(hnav_ins_error_filter_step(f, &d.u[k], nullptr, nullptr), HNAV_ERROR_NULL_ARGUMENT);
    }
    EXPECT_EQ(f.x(), untouched.x());
    EXPECT_EQ(f.P(), untouched.P());

    Model blind(0); // no noise at all and nothing unknown: S is zero
    blind.P0.setZero();
    blind.Lambda0.setZero();
    for (const hnav_ins_error_form form : {HNAV_INS_ERROR_AUGMENTED, HNAV_INS_ERROR_DIFFERENCED, HNAV_INS_ERROR_PLAIN}) {
        Handle g(blind, options_of(form));
        EXPECT_EQ(hnav_ins_error_filter_step(g, &d.u[0], &d.z[0], nullptr), HNAV_ERROR_SOLVER);
        EXPECT_NE(std::string(hnav_ins_error_filter_message(g)).find("singular"), std::string::npos);
    }
}

TEST(InsErrorFilter, NullIsAnswered) {
    const Model m;
    const hnav_ins_error_model view = m.view();
    Handle f(m, hnav_ins_error_defaults());
    double number[9];
    size_t bytes;
    auto info = hnav_sized<hnav_ins_error_info>();
    const auto input = hnav_sized<hnav_ins_error_run_input>();
    const auto output = hnav_sized<hnav_ins_error_run_output>();
    hnav_ins_error_filter_destroy(nullptr);
    EXPECT_STREQ(hnav_ins_error_filter_message(nullptr), "filter is null");
    EXPECT_STREQ(hnav_ins_error_filter_warning(nullptr), "filter is null");
    for (const hnav_status answer : {hnav_ins_error_filter_reset(nullptr),
                                     hnav_ins_error_filter_separability(nullptr, number),
                                     hnav_ins_error_filter_separability(f, nullptr),
                                     hnav_ins_error_filter_replace_model(nullptr, &view),
                                     hnav_ins_error_filter_step(nullptr, number, number, nullptr),
                                     hnav_ins_error_filter_estimate(nullptr, number, number),
                                     hnav_ins_error_filter_covariance(nullptr, number),
                                     hnav_ins_error_filter_covariance(f, nullptr),
                                     hnav_ins_error_filter_faults(nullptr, number, number, number),
                                     hnav_ins_error_filter_coloured_error(nullptr, number, number, number),
                                     hnav_ins_error_filter_innovation(nullptr, number, number, number),
                                     hnav_ins_error_filter_noise(nullptr, number, number),
                                     hnav_ins_error_filter_info(nullptr, &info),
                                     hnav_ins_error_filter_info(f, nullptr),
                                     hnav_ins_error_filter_run(nullptr, 1, &input, &output, nullptr),
                                     hnav_ins_error_filter_run(f, 1, nullptr, &output, nullptr),
                                     hnav_ins_error_filter_run(f, 1, &input, nullptr, nullptr),
                                     hnav_ins_error_filter_run(f, 1, &input, &output, nullptr),
                                     hnav_ins_error_filter_state_size(nullptr, &bytes),
                                     hnav_ins_error_filter_state_size(f, nullptr),
                                     hnav_ins_error_filter_save(nullptr, number, 9),
                                     hnav_ins_error_filter_save(f, nullptr, 9),
                                     hnav_ins_error_filter_load(nullptr, number, 9),
                                     hnav_ins_error_filter_load(f, nullptr, 9)})
        EXPECT_EQ(answer, HNAV_ERROR_NULL_ARGUMENT);
    EXPECT_EQ(hnav_ins_error_filter_run(f, 0, &input, &output, nullptr), HNAV_OK);
}

TEST(InsErrorFilter, ARunStopsAtTheFirstWrongRowAndTellsHowFarItCame) {
    const Model m;
    Data d = samples(m, 20, 15);
    d.z[3 * 12 + 1] = infinity;
    Handle f(m, hnav_ins_error_defaults());
    const hnav_ins_error_run_input input = {sizeof(hnav_ins_error_run_input), d.u.data(), d.z.data(), nullptr};
    std::vector<double> x(60, not_a_number);
    auto output = hnav_sized<hnav_ins_error_run_output>();
    output.x = x.data();
    size_t done;
    EXPECT_EQ(hnav_ins_error_filter_run(f, 20, &input, &output, &done), HNAV_ERROR_NON_FINITE);
    EXPECT_EQ(done, 12u);
    EXPECT_TRUE(std::isfinite(x[35]) && std::isnan(x[36]));
}

// ------------------------------------------------------------------------------------------------ heap

#ifdef HNAV_HEAP_IS_COUNTED

namespace {

// Every call of a filter, on n states, n channels and a full Qv when `full`.
long allocations_after_create(int n, hnav_ins_error_form form, hnav_noise_scaling scaling, int lag, bool full) {
    Square A = 0.9 * Square::Identity(n, n), I = Square::Identity(n, n), An = 0.99 * I, QU = 0.02 * I, Qv = I, Ac = -0.5 * I,
           Anc = -0.1 * I;
    A(0, n - 1) = 0.1;
    if (full) Qv(0, n - 1) = Qv(n - 1, 0) = 0.1;
    auto m = hnav_sized<hnav_ins_error_model>();
    m.nx = m.nz = n;
    m.A = A.data();
    m.H = m.P0 = m.Qw = I.data();
    m.Qv = Qv.data();
    m.An = An.data();
    m.QU = QU.data();
    hnav_ins_error_model other = m; // continuous, so that the exponential is called too
    other.interval_s = 0.1;
    other.A = Ac.data();
    other.An = Anc.data();
    hnav_ins_error_options o = options_of(form, scaling);
    o.lag = lag;
    o.window = 5;
    Handle f(m, o);
    size_t bytes;
    EXPECT_EQ(hnav_ins_error_filter_state_size(f, &bytes), HNAV_OK);
    std::vector<unsigned char> saved(bytes);
    std::vector<double> z(n), out(10 * n * n);
    hnav_status worst = HNAV_OK;
    const auto check = [&worst](hnav_status status) { worst = worst == HNAV_OK ? status : worst; };
    heap::allocations = 0;
    heap::counting = true;
    for (int k = 0; k < 12; ++k) {
        for (int i = 0; i < n; ++i) z[i] = std::sin(7.0 * i + 3 * k);
        if (k == 7) z[n / 2] = not_a_number;
        check(hnav_ins_error_filter_step(f, nullptr, z.data(), nullptr));
        check(hnav_ins_error_filter_estimate(f, out.data(), out.data() + n));
        check(hnav_ins_error_filter_covariance(f, out.data()));
        check(hnav_ins_error_filter_coloured_error(f, out.data(), out.data() + n, out.data() + 2 * n));
        check(hnav_ins_error_filter_innovation(f, out.data(), out.data() + n, out.data() + n));
        check(hnav_ins_error_filter_noise(f, out.data(), out.data() + n));
        if (k == 9) check(hnav_ins_error_filter_replace_model(f, &other));
    }
    check(hnav_ins_error_filter_save(f, saved.data(), bytes));
    check(hnav_ins_error_filter_load(f, saved.data(), bytes));
    check(hnav_ins_error_filter_reset(f));
    heap::counting = false;
    EXPECT_EQ(worst, HNAV_OK) << hnav_ins_error_filter_message(f);
    return heap::allocations;
}

} // namespace

TEST(InsErrorFilterHeap, NothingIsAllocatedAfterCreate) {
    for (const int n : {2, 8, 32})
        for (int form = HNAV_INS_ERROR_MDKF; form <= HNAV_INS_ERROR_PLAIN; ++form)
            for (int scaling = HNAV_NOISE_SCALING_NONE; scaling <= HNAV_NOISE_SCALING_JOINT; ++scaling)
                for (const int lag : {0, 1})
                    EXPECT_EQ(allocations_after_create(n, hnav_ins_error_form(form), hnav_noise_scaling(scaling), lag,
                                                       scaling == HNAV_NOISE_SCALING_NONE),
                              0)
                        << "n " << n << ", form " << form << ", scaling " << scaling << ", lag " << lag;
}
#endif
