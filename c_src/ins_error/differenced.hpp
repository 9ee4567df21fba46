// Measurement differencing: z(k) - An z(k-1) no longer holds lambda, only its driving noise.
//
//   mu(k) = z(k) - An z(k-1) = Hd x(k-1) + H B u(k-1) + xi,  Hd = H A - An H
//   xi = H G w(k-1) + Bn U(k-1) + v(k) - An v(k-1),  R = H G Qw G'H' + Bn QU Bn' + Qv + An Qv An',  C = G Qw G'H'
//
// xi is correlated with w(k-1) (covariance C) and, when v is not zero, with itself: E[xi(k) xi(k-1)'] = -An Qv.
#pragma once

#include "ins_error/augmented.hpp"

#include <Eigen/LU>

#include <limits>

namespace hnav {

// What both differencing filters need of a model.
struct Differences {
    Differences(MatrixArena& work, const LinearModel& of)
        : model(of),
          Hd(work.matrix(model.nz, model.nx)),
          HB(work.matrix(model.nz, model.nu)),
          C(work.matrix(model.nx, model.nz)),
          driven(work.matrix(model.nz, model.nz)) {}

    void prepare() {
        Hd.noalias() = model.H * model.A;
        Hd.noalias() -= model.An * model.H;
        HB.noalias() = model.H * model.B;
        C.noalias() = model.Q * model.H.transpose();
        driven.noalias() = model.H * C;
        driven += model.Ql;
    }

    // mu - HB u - Hd x in the channels whose difference exists; the number of these channels goes to `present`.
    int innovate(const double* z, const double* z_before, const double* u, const Vector& x, int* present, Vector& nu) const {
        int count = 0;
        for (int i = 0; i < model.nz; ++i) {
            double e = z[i];
            for (int j = 0; j < model.nz; ++j)
                if (model.An(i, j) != 0) e -= model.An(i, j) * z_before[j]; // NaN when one of them was missing
            for (int j = 0; j < model.nu; ++j) e -= HB(i, j) * u[j];
            for (int j = 0; j < model.nx; ++j) e -= Hd(i, j) * x[j];
            nu[i] = e;
            if (!std::isnan(e)) present[count++] = i;
        }
        return count;
    }

    const LinearModel& model;
    Matrix Hd, HB, C;
    Matrix driven; // R without v: H G Qw G'H' + Bn QU Bn'
};

// The paper's filter as it is printed, (12)-(16), and its adaptation, up to (24). Step k uses mu(k) = z(k+1) - An z(k), so
// the estimate is of the step before the newest measurement; z(0) alone says nothing.
//
//   K = (P Hd' + C) Omega*^-1,  P <- P - K Omega K',  Omega = Hd P Hd' + R + Hd C + C'Hd'
//   Omega*: with S* R for R,  S* = diag(max(1, S_ii)),  S = [(1/M) sum Delta Delta' - Hd P Hd' - Hd C - C'Hd'] R^-1
//
// What is wrong with it: xi is not white; C belongs in the next prediction; R also holds process noise; max(1, .) is
// biased; the adaptation reaches K but not P. It is here to be compared with.
class Printed {
public:
    Printed(MatrixArena& state, MatrixArena& work, const LinearModel& model, int window)
        : model_(model),
          window_(window),
          x_(state.vector(model.nx)),
          P_(state.matrix(model.nx, model.nx)),
          u_before_(state.vector(model.nu)),
          scale_(state.vector(model.nz)),
          ring_(state.doubles(window * model.nz)),
          seen_(state.doubles(1)),
          d_(work, model),
          R_(work.matrix(model.nz, model.nz)),
          R_inverse_(work.matrix(model.nz, model.nz)),
          base_(work.matrix(model.nz, model.nz)),
          T_(work.matrix(model.nx, model.nx)),
          HP_(work.matrix(model.nz, model.nx)),
          moved_(work.vector(model.nx)) {}

    void prepare() {
        d_.prepare();
        Small R = d_.driven;
        R += model_.Qv + model_.An * model_.Qv * model_.An.transpose();
        R_ = R;
        // A noise-free combination of channels has no scale; the pseudo-inverse leaves it out.
        R_inverse_ = Eigen::CompleteOrthogonalDecomposition<Small>(R).pseudoInverse();
    }

    void start() {
        x_ = model_.x0;
        P_ = model_.P0;
        u_before_.setZero();
        scale_.setOnes();
        std::fill(ring_, ring_ + window_ * model_.nz, std::numeric_limits<double>::quiet_NaN());
        *seen_ = 0;
    }

    const double* scale() const { return scale_.data(); }
    const Vector& shown_x() const { return x_; }
    const Matrix& shown_P() const { return P_; }

    // first: x0 is already the prior of the step that mu is about. False: Omega is singular.
    bool step(const double* u, const double* z, const double* z_before, bool first, int* present, StepResult& out) {
        if (!first) predict();
        for (int j = 0; j < model_.nu; ++j) u_before_[j] = u[j];
        HP_.noalias() = d_.Hd * P_;
        base_.noalias() = HP_ * d_.Hd.transpose();
        base_.noalias() += d_.Hd * d_.C;
        base_.noalias() += d_.C.transpose() * d_.Hd.transpose();
        const int count = d_.innovate(z, z_before, u, x_, present, out.innovation);
        if (window_ > 0 && count > 0) match(out.innovation);
        for (int i = 0; i < model_.nz; ++i)
            for (int j = 0; j < model_.nz; ++j) out.S(i, j) = base_(i, j) + scale_[i] * R_(i, j);
        return count == 0 || correct(present, count, out);
    }

private:
    void predict() {
        moved_.noalias() = model_.A * x_;
        moved_.noalias() += model_.B * u_before_;
        x_ = moved_;
        T_.noalias() = model_.A * P_;
        P_.noalias() = T_ * model_.A.transpose();
        P_ += model_.Q;
        symmetrise(P_);
    }

    // Channels missing together leave no product in the window; such a product counts as expected.
    void match(const Vector& delta) {
        const int nz = model_.nz;
        std::copy(delta.data(), delta.data() + nz, ring_ + nz * static_cast<int>(std::fmod(*seen_, window_)));
        *seen_ += 1;
        if (*seen_ < window_) return;
        for (int i = 0; i < nz; ++i) {
            double s = 0;
            for (int j = 0; j < nz; ++j) {
                double sum = 0;
                int together = 0;
                for (int k = 0; k < window_; ++k) {
                    const double product = ring_[k * nz + i] * ring_[k * nz + j];
                    if (std::isnan(product)) continue;
                    sum += product;
                    ++together;
                }
                s += (together ? sum / together - base_(i, j) : R_(i, j)) * R_inverse_(j, i);
            }
            scale_[i] = std::fmax(1, s);
        }
    }

    bool correct(const int* present, int count, StepResult& out) {
        const int nx = model_.nx;
        Small Omega(count, count), adapted(count, count), T(count, nx), e(count, 1);
        for (int a = 0; a < count; ++a) {
            e(a) = out.innovation[present[a]];
            for (int b = 0; b < count; ++b) {
                adapted(a, b) = out.S(present[a], present[b]);
                Omega(a, b) = base_(present[a], present[b]) + R_(present[a], present[b]);
            }
            for (int j = 0; j < nx; ++j) T(a, j) = HP_(present[a], j) + d_.C(j, present[a]);
        }
        // Not symmetric once S* is not the identity and R not diagonal: no Cholesky.
        const Eigen::PartialPivLU<Small> lu(adapted.transpose());
        if (!(std::fabs(lu.determinant()) > 0)) return false;
        const Small K = lu.solve(T).transpose(); // K Omega* = T'
        const Small weighted = Eigen::PartialPivLU<Small>(adapted).solve(e);
        *out.nis = e.col(0).dot(weighted.col(0));
        const Small gained = K * e;
        x_ += gained.col(0);
        const Small known = K * Omega * K.transpose();
        P_ -= known;
        symmetrise(P_);
        return true;
    }

    const LinearModel& model_;
    const int window_;
    Vector x_;
    Matrix P_;
    Vector u_before_, scale_;
    double* ring_; // the last innovations, one row each
    double* seen_;
    Differences d_;
    Matrix R_, R_inverse_, base_, T_, HP_;
    Vector moved_;
};

// Differencing done right: the estimate of the step of the newest measurement, C where it belongs, z(0) used. Exact when
// v = 0; otherwise xi is taken for white, which is what differencing cannot avoid without more states.
//
//   e = z(k) - An z(k-1) - H B u - Hd x,  S = Hd P Hd' + R,  K = (A P Hd' + C) S^-1,  x <- A x + B u + K e
//   P <- (A - K Hd) P (A - K Hd)' + (I - K H) G Qw G' (I - K H)' + K (Bn QU Bn' + Qv + An Qv An') K'
//   start: ordinary correction by z(0) with R0 = Qv + Lambda0
//   lag one: x(k-1|k) = x + D e,  D = P Hd' S^-1
//
//   A. E. Bryson, L. J. Henrikson, Estimation using sampled data containing sequentially correlated noise,
//   J. Spacecraft and Rockets 5(6), 1968.
class Differenced {
public:
    Differenced(MatrixArena& state, MatrixArena& work, const LinearModel& model, bool joseph, bool lag)
        : model_(model),
          joseph_(joseph),
          lag_(lag),
          x_(state.vector(model.nx)),
          P_(state.matrix(model.nx, model.nx)),
          x_before_(state.vector(lag ? model.nx : 0)),
          P_before_(state.matrix(lag ? model.nx : 0, lag ? model.nx : 0)),
          v_before_(state.vector(model.nz)),
          d_(work, model),
          HP_(work.matrix(model.nz, model.nx)),
          base_(work.matrix(model.nz, model.nz)),
          moved_(work.vector(model.nx)),
          fresh_(work.doubles(model.nz)),
          past_(work.doubles(model.nz)),
          past_healthy_(work.doubles(model.nz)),
          S_(work.matrix(model.nz, model.nz)),
          inverse_(work, model.nz) {}

    void prepare() { d_.prepare(); }

    void start() {
        x_ = model_.x0;
        P_ = model_.P0;
        v_before_.setZero();
        keep_before();
    }

    // z(0) is the only sample that says where x is, not how it moves.
    bool correct_first(const double* z, const int* present, int count, NoiseScale& noise, StepResult& out) {
        const int nz = model_.nz;
        HP_.noalias() = model_.H * P_;
        base_.noalias() = HP_ * model_.H.transpose();
        base_ += model_.Lambda0;
        out.innovation.setConstant(std::numeric_limits<double>::quiet_NaN());
        for (int a = 0; a < count; ++a) out.innovation[present[a]] = z[present[a]] - model_.H.row(present[a]).dot(x_);
        for (int i = 0; i < nz; ++i) {
            fresh_[i] = model_.Qv(i, i);
            past_[i] = past_healthy_[i] = 0;
        }
        if (!noise.update({out.innovation.data(), base_, fresh_, past_, past_healthy_, present, count})) return false;
        Small white(nz, nz);
        for (int i = 0; i < nz; ++i)
            for (int j = 0; j < nz; ++j) white(i, j) = scaled_v(i, j, noise);
        out.S = base_ + white;
        remember(noise);
        if (!factor(present, count, out)) return false;
        Small K = Small::Zero(model_.nx, nz);
        gain(HP_.transpose(), present, count, K);
        weigh(present, count, out, K, x_);
        const Small E = Small::Identity(model_.nx, model_.nx) - K * model_.H;
        const Small R = white + model_.Lambda0;
        const Small joint = joseph_ ? Small(E * P_ * E.transpose() + K * R * K.transpose()) : Small(E * P_);
        P_ = joint;
        symmetrise(P_);
        keep_before();
        return true;
    }

    bool step(const double* u, const double* z, const double* z_before, int* present, NoiseScale& noise, StepResult& out) {
        const int nx = model_.nx, nz = model_.nz;
        const int count = d_.innovate(z, z_before, u, x_, present, out.innovation);
        // An V An' with the noise of the sample before as it was scaled then; its diagonal goes to the adaptation.
        Small old(nz, nz), healthy = model_.An * model_.Qv * model_.An.transpose();
        old = healthy;
        if (model_.Qv_is_diagonal) old = model_.An * v_before_.asDiagonal() * model_.An.transpose();
        HP_.noalias() = d_.Hd * P_;
        base_.noalias() = HP_ * d_.Hd.transpose();
        base_ += d_.driven;
        for (int i = 0; i < nz; ++i) {
            fresh_[i] = model_.Qv(i, i);
            past_[i] = old(i, i);
            past_healthy_[i] = healthy(i, i);
            for (int j = 0; j < nz; ++j)
                if (i != j) base_(i, j) += old(i, j);
        }
        if (!noise.update({out.innovation.data(), base_, fresh_, past_, past_healthy_, present, count})) return false;
        Small R(nz, nz); // of v alone, both samples
        for (int i = 0; i < nz; ++i)
            for (int j = 0; j < nz; ++j) {
                R(i, j) = old(i, j) + scaled_v(i, j, noise);
                out.S(i, j) = base_(i, j) + (i == j ? R(i, i) : scaled_v(i, j, noise));
            }
        remember(noise);
        if (!factor(present, count, out)) return false;

        const Small cross = HP_.transpose(); // P Hd'
        if (lag_) {
            Small D = Small::Zero(nx, nz);
            gain(cross, present, count, D);
            x_before_ = x_;
            weigh(present, count, out, D, x_before_);
            const Small E = Small::Identity(nx, nx) - D * d_.Hd;
            const Small noise_of_mu = d_.driven + R;
            const Small joint = E * P_ * E.transpose() + D * noise_of_mu * D.transpose();
            P_before_ = joint;
            symmetrise(P_before_);
        }
        Small K = Small::Zero(nx, nz);
        const Small T = model_.A * cross + d_.C;
        gain(T, present, count, K);
        moved_.noalias() = model_.A * x_;
        for (int i = 0; i < nx; ++i)
            for (int j = 0; j < model_.nu; ++j) moved_[i] += model_.B(i, j) * u[j];
        weigh(present, count, out, K, moved_);
        x_ = moved_;
        Small next;
        if (joseph_) {
            const Small E = model_.A - K * d_.Hd, G = Small::Identity(nx, nx) - K * model_.H;
            const Small driving = model_.Ql + R;
            next = E * P_ * E.transpose() + G * model_.Q * G.transpose() + K * driving * K.transpose();
        } else {
            next = model_.A * P_ * model_.A.transpose() + model_.Q - K * T.transpose();
        }
        P_ = next;
        symmetrise(P_);
        return true;
    }

    const Vector& shown_x() const { return lag_ ? x_before_ : x_; }
    const Matrix& shown_P() const { return lag_ ? P_before_ : P_; }

private:
    double scaled_v(int i, int j, const NoiseScale& noise) const {
        return i == j ? noise.scale()[i] * model_.Qv(i, i) : std::sqrt(noise.scale()[i] * noise.scale()[j]) * model_.Qv(i, j);
    }

    void remember(const NoiseScale& noise) {
        for (int i = 0; i < model_.nz; ++i) v_before_[i] = noise.scale()[i] * model_.Qv(i, i);
    }

    void keep_before() {
        if (!lag_) return;
        x_before_ = x_;
        P_before_ = P_;
    }

    bool factor(const int* present, int count, const StepResult& out) {
        for (int a = 0; a < count; ++a)
            for (int b = 0; b < count; ++b) S_(a, b) = out.S(present[a], present[b]);
        return inverse_.factor(S_, count);
    }

    // Columns of the missing channels stay zero.
    void gain(const Small& T, const int* present, int count, Small& K) const {
        for (int a = 0; a < count; ++a)
            for (int b = 0; b < count; ++b) K.col(present[a]) += T.col(present[b]) * inverse_.inverse(b, a);
    }

    // estimate += K nu, and nu' S^-1 nu.
    void weigh(const int* present, int count, StepResult& out, const Small& K, Vector& estimate) const {
        *out.nis = 0;
        for (int a = 0; a < count; ++a) {
            estimate += K.col(present[a]) * out.innovation[present[a]];
            for (int b = 0; b < count; ++b)
                *out.nis += out.innovation[present[a]] * inverse_.inverse(a, b) * out.innovation[present[b]];
        }
    }

    const LinearModel& model_;
    const bool joseph_, lag_;
    Vector x_;
    Matrix P_;
    Vector x_before_;
    Matrix P_before_;
    Vector v_before_; // variance of v in the sample before, as scaled then
    Differences d_;
    Matrix HP_, base_;
    Vector moved_;
    double *fresh_, *past_, *past_healthy_;
    Matrix S_;
    LowerInverse inverse_;
};

} // namespace hnav
