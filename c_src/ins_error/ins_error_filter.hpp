// The filter in its five forms: a step, its outputs, and the saved state, from which it continues bit for bit.
#pragma once

#include "ins_error/augmented.hpp"
#include "ins_error/differenced.hpp"

#include <limits>
#include <optional>

namespace hnav {

class InsErrorFilter {
public:
    using Model = LinearModel;

    // state: contents of a saved filter; work: the rest; spare: as many bytes as state. Constructed twice, the first time on
    // arenas without memory, to count the bytes.
    InsErrorFilter(MatrixArena& state, MatrixArena& work, void* spare, const ModelData& data, const hnav_ins_error_options& o)
        : model(work, data),
          options_(o),
          state_(state.doubles(0)),
          spare_(static_cast<double*>(spare)),
          steps_(state.doubles(1)),
          z_(state.vector(data.nz)),
          z_before_(state.vector(data.nz)),
          result_(state, data.nz),
          present_(work.integers(data.nz)),
          no_bias_(work.doubles(data.nz)) {
        int scaling = is_printed() ? HNAV_NOISE_SCALING_NONE : o.noise_scaling; // MDKF has none, AMDKF its own
        const bool has_lambda = o.form == HNAV_INS_ERROR_AUGMENTED && data.An;
        if (scaling == HNAV_NOISE_SCALING_JOINT) {
            // Only a state lambda can jump; in the other forms channels are tested for their noise only.
            scaling = has_lambda ? HNAV_NOISE_SCALING_NONE : HNAV_NOISE_SCALING_HMM;
            if (has_lambda) joint_.emplace(state, work, data.nz, options_);
        }
        noise_.emplace(state, work, data.nz, options_, scaling);
        const bool joseph = o.joseph != 0, lag = o.lag != 0;
        if (is_printed()) printed_.emplace(state, work, model, o.form == HNAV_INS_ERROR_AMDKF ? o.window : 0);
        else if (o.form == HNAV_INS_ERROR_DIFFERENCED) differenced_.emplace(state, work, model, joseph, lag);
        else kalman_.emplace(state, work, model, has_lambda, joseph, lag);
        state_count_ = static_cast<int>(state.used() / sizeof(double));
    }
    InsErrorFilter(const InsErrorFilter&) = delete;

    LinearModel model;

    // A factor for each channel has no meaning for correlated noise.
    static bool scaling_has_meaning(const hnav_ins_error_options& o, const ModelData& m, Refusal& why) {
        const bool scaled = o.form >= HNAV_INS_ERROR_DIFFERENCED && o.noise_scaling != HNAV_NOISE_SCALING_NONE;
        if (!scaled || !m.Qv) return true;
        for (int i = 0; i < m.nz; ++i)
            for (int j = 0; j < m.nz; ++j)
                if (i != j && m.Qv[i * m.nz + j] != 0)
                    return why.refuse(Refusal::impossible, "Qv[%d][%d] = %g: noise_scaling needs a diagonal Qv; choose none", i,
                                      j, m.Qv[i * m.nz + j]);
        return true;
    }

    // Once, when the model is assigned.
    void create() {
        std::fill(no_bias_, no_bias_ + model.nz, 0.0);
        noise_->create();
        if (joint_) joint_->create();
        prepare();
        reset();
    }

    // After the model changed.
    void prepare() {
        if (printed_) printed_->prepare();
        if (differenced_) differenced_->prepare();
        if (kalman_) kalman_->prepare();
    }

    // Restores x0 and P0, no samples.
    void reset() {
        *steps_ = 0;
        for (Vector* z : {&z_, &z_before_, &result_.innovation}) z->setConstant(nan);
        result_.S.setConstant(nan);
        *result_.nis = nan;
        noise_->reset();
        if (joint_) joint_->reset();
        if (printed_) printed_->start();
        if (differenced_) differenced_->start();
        if (kalman_) kalman_->start();
    }

    // u: held since the step before (not used by the first step); z: NaN where a channel is missing. False: a covariance is
    // singular or negative, or the estimate would not be finite; nothing is changed then.
    bool step(const double* u, const double* z) {
        std::copy(state_, state_ + state_count_, spare_);
        const bool first = *steps_ == 0;
        z_before_ = z_;
        int count = 0;
        for (int i = 0; i < model.nz; ++i) {
            z_[i] = z[i];
            if (!std::isnan(z[i])) present_[count++] = i;
        }
        *result_.nis = nan;
        bool good = true;
        if (kalman_) {
            if (!first) kalman_->predict(u);
            good = kalman_->correct(z, present_, count, !first, *noise_, joint_ ? &*joint_ : nullptr, result_);
        } else if (differenced_) {
            good = first ? differenced_->correct_first(z, present_, count, *noise_, result_)
                         : differenced_->step(u, z, z_before_.data(), present_, *noise_, result_);
        } else if (!first) { // the printed filter does not use z(0) alone
            good = printed_->step(u, z, z_before_.data(), *steps_ == 1, present_, result_);
        }
        *steps_ += 1;
        const bool seen = !result_.innovation.array().isNaN().all();
        if (!seen) *result_.nis = nan;
        if (good && (!seen || std::isfinite(*result_.nis)) && has_answer()) return true;
        std::copy(spare_, spare_ + state_count_, state_);
        return false;
    }

    double steps() const { return *steps_; }
    // The step of the outputs, counted from 0.
    double shown_step() const { return std::fmax(0, *steps_ - 1 - is_late()); }

    // State, followed by lambda in the augmented form.
    const Vector& X() const {
        return kalman_ ? kalman_->shown_X() : differenced_ ? differenced_->shown_x() : printed_->shown_x();
    }
    const Matrix& P() const {
        return kalman_ ? kalman_->shown_P() : differenced_ ? differenced_->shown_P() : printed_->shown_P();
    }
    // The measurement of the step of the outputs.
    const Vector& shown_z() const { return is_late() && *steps_ >= 2 ? z_before_ : z_; }
    bool estimates_lambda() const { return P().rows() > model.nx; }

    // Rounding can make a variance of zero slightly negative.
    double variance(int i) const { return std::fmax(0, P()(i, i)); }

    // State and standard deviations, nx each; null outputs are not written, here and below.
    void estimate(double* x, double* sigma) const {
        for (int i = 0; i < model.nx; ++i) {
            if (x) x[i] = X()[i];
            if (sigma) sigma[i] = std::sqrt(variance(i));
        }
    }

    // Covariance of the state, nx x nx, row-major.
    void covariance(double* out) const {
        const int nx = model.nx;
        for (int i = 0; out && i < nx; ++i)
            for (int j = 0; j < nx; ++j) out[i * nx + j] = i == j ? variance(i) : P()(i, j);
    }

    // The measurement without its coloured error, nz.
    void compensated(double* out) const {
        if (!out) return;
        lambda(out, nullptr);
        for (int i = 0; i < model.nz; ++i) out[i] = shown_z()[i] - out[i];
    }

    // Coloured errors. Forms without a state lambda return z - H x, which is
    // lambda when v = 0.
    void lambda(double* value, double* sigma) const {
        const int nx = model.nx;
        for (int i = 0; i < model.nz; ++i) {
            const double hx = model.H.row(i).dot(X().head(nx));
            const bool state = estimates_lambda();
            if (value) value[i] = state ? X()[nx + i] : shown_z()[i] - hx;
            if (!sigma) continue;
            double variance = state ? P()(nx + i, nx + i) : 0;
            if (!state) // (H P H')_ii
                for (int j = 0; j < nx; ++j) variance += model.H(i, j) * model.H.row(i).dot(P().row(j));
            sigma[i] = std::sqrt(std::fmax(0, variance));
        }
    }

    const hnav_ins_error_options& options() const { return options_; }
    const StepResult& result() const { return result_; }
    const double* noise_scale() const { return printed_ ? printed_->scale() : joint_ ? joint_->scale() : noise_->scale(); }
    const double* fault_probability() const { return joint_ ? joint_->noise_probability() : noise_->fault_probability(); }
    // By channel; zero without a test.
    const double* bias_probability() const { return joint_ ? joint_->bias_probability() : no_bias_; }
    double process_probability() const { return joint_ ? joint_->process_probability() : 0; }

    int state_count() const { return state_count_; }
    double* state() { return state_; }
    const double* state() const { return state_; }

private:
    static constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    static constexpr double beyond = 1e150; // the square of an estimate must be a number

    // Finite numbers, and covariances that are positive semidefinite up to rounding: a clearly negative one comes from matrices of
    // too different magnitudes. The printed forms do not preserve the sign by their equations.
    bool has_answer() const {
        for (int i = 0; i < model.nz; ++i)
            if (!(noise_scale()[i] > 0 && std::isfinite(noise_scale()[i]) && std::isfinite(fault_probability()[i]))) return false;
        if (!std::isfinite(process_probability())) return false;
        const auto variances = P().diagonal().array();
        if (!X().allFinite() || !(X().cwiseAbs().maxCoeff() < beyond) || !variances.isFinite().all()) return false;
        return is_printed() || (variances.minCoeff() >= -1e-9 * variances.maxCoeff() && !(*result_.nis < 0));
    }

    bool is_printed() const { return options_.form < HNAV_INS_ERROR_DIFFERENCED; }
    bool is_late() const { return is_printed() || options_.lag != 0; }

    const hnav_ins_error_options options_;
    double* state_;
    double* spare_;
    int state_count_ = 0;
    double* steps_; // a double, because saved states are numbers
    Vector z_, z_before_;
    StepResult result_;
    int* present_;
    double* no_bias_;
    std::optional<NoiseScale> noise_;
    std::optional<JointHypotheses> joint_;
    std::optional<Augmented> kalman_;
    std::optional<Printed> printed_;
    std::optional<Differenced> differenced_;
};

} // namespace hnav
