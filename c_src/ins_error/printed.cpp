#include "ins_error/differenced.hpp"

#include "maths/pseudo_inverse.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <limits>

namespace hnav {

Printed::Printed(MatrixArena& state, MatrixArena& work, const LinearModel& model, int window)
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

void Printed::prepare() {
    d_.prepare();
    Small R = d_.driven;
    R += model_.Qv + model_.An * model_.Qv * model_.An.transpose();
    R_ = R;
    // A noise-free combination of channels has no scale; the pseudo-inverse leaves it out.
    R_inverse_ = pseudo_inverse(R);
}

void Printed::start() {
    x_ = model_.x0;
    P_ = model_.P0;
    u_before_.setZero();
    scale_.setOnes();
    std::fill(ring_, ring_ + window_ * model_.nz, std::numeric_limits<double>::quiet_NaN());
    *seen_ = 0;
}

bool Printed::step(const double* u, const double* z, const double* z_before, bool first, int* present, StepResult& out) {
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

void Printed::predict() {
    moved_.noalias() = model_.A * x_;
    moved_.noalias() += model_.B * u_before_;
    x_ = moved_;
    T_.noalias() = model_.A * P_;
    P_.noalias() = T_ * model_.A.transpose();
    P_ += model_.Q;
    symmetrise(P_);
}

void Printed::match(const Vector& delta) {
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

bool Printed::correct(const int* present, int count, StepResult& out) {
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

} // namespace hnav
