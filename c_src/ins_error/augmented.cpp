#include "ins_error/augmented.hpp"

#include <cmath>
#include <limits>

namespace hnav {

Augmented::Augmented(MatrixArena& state, MatrixArena& work, const LinearModel& model, bool with_colour, bool joseph, bool lag)
    : model_(model),
      nl_(with_colour ? model.nz : 0),
      n_(model.nx + nl_),
      joseph_(joseph),
      lag_(lag),
      X_(state.vector(n_)),
      P_(state.matrix(n_, n_)),
      X_before_(state.vector(lag ? n_ : 0)),
      P_before_(state.matrix(lag ? n_ : 0, lag ? n_ : 0)),
      F_(work, n_, n_),
      H_(work, model.nz, n_),
      Q_(work.matrix(n_, n_)),
      Q_now_(work.matrix(n_, n_)),
      HQH_(work.matrix(model.nz, model.nz)),
      HF_(work.matrix(model.nz, n_)),
      FP_(work.matrix(n_, n_)),
      PF_(work.matrix(n_, n_)),
      HP_(work.matrix(model.nz, n_)),
      base_(work.matrix(model.nz, model.nz)),
      R_(work.vector(model.nz)),
      zero_(work.doubles(model.nz)),
      fresh_(work.doubles(model.nz)),
      g_(work.doubles(n_)),
      K_(work.doubles(n_)),
      m_(work.doubles(n_)),
      S_(work.matrix(model.nz, model.nz)),
      Rm_(work.matrix(model.nz, model.nz)),
      V_(work.matrix(n_, model.nz)),
      D_(work.matrix(n_, model.nz)),
      E_(work.matrix(n_, n_)),
      T_(work.matrix(n_, n_)),
      inverse_(work, model.nz) {}

void Augmented::prepare() {
    const int nx = model_.nx;
    F_.fill(n_, [&](int i, int j) {
        if (i < nx) return j < nx ? model_.A(i, j) : 0.0;
        return j < nx ? 0.0 : model_.An(i - nx, j - nx);
    });
    H_.fill(n_, [&](int i, int j) { return j < nx ? model_.H(i, j) : double(i == j - nx); });
    HF_.leftCols(nx).noalias() = model_.H * model_.A;
    if (nl_) HF_.rightCols(nl_) = model_.An;
    Q_.setZero();
    Q_.topLeftCorner(nx, nx) = model_.Q;
    if (nl_) Q_.bottomRightCorner(nl_, nl_) = model_.Ql;
    Q_now_ = Q_;
    V_.topRows(nx).noalias() = model_.Q * model_.H.transpose();
    HQH_.noalias() = model_.H * V_.topRows(nx);
    // Sequential corrections need uncorrelated noise of the channels.
    sequential_ = model_.Qv_is_diagonal && (nl_ || LinearModel::is_diagonal(model_.Lambda0));
    for (int i = 0; i < model_.nz; ++i) {
        zero_[i] = 0;
        fresh_[i] = model_.Qv(i, i);
    }
}

void Augmented::start() {
    X_.setZero();
    X_.head(model_.nx) = model_.x0;
    P_.setZero();
    P_.topLeftCorner(model_.nx, model_.nx) = model_.P0;
    if (nl_) P_.bottomRightCorner(nl_, nl_) = model_.Lambda0;
    if (lag_) {
        X_before_ = X_;
        P_before_ = P_;
    }
}

void Augmented::predict(const double* u) {
    if (lag_) {
        X_before_ = X_;
        P_before_ = P_;
    }
    F_.times(P_, FP_);
    for (int i = 0; i < n_; ++i) m_[i] = F_.dot(i, X_.data());
    for (int i = 0; i < model_.nx; ++i)
        for (int j = 0; j < model_.nu; ++j) m_[i] += model_.B(i, j) * u[j];
    for (int i = 0; i < n_; ++i) X_[i] = m_[i];
    PF_ = FP_.transpose();
    for (int i = 0; i < n_; ++i) {
        double* row = P_.data() + i * n_;
        F_.row_times(i, PF_, row, i);
        for (int j = i; j < n_; ++j) row[j] += Q_(i, j);
    }
    mirror_upper(P_);
}

void Augmented::expect() {
    H_.times(P_, HP_);
    for (int i = 0; i < model_.nz; ++i)
        for (int j = 0; j < model_.nz; ++j) base_(i, j) = H_.dot(j, HP_.data() + i * n_);
    if (!nl_) base_ += model_.Lambda0;
}

void Augmented::enlarge(const JointHypotheses& joint) {
    const int nx = model_.nx;
    const double motion = joint.motion_factor() - 1, colour = joint.colour_factor() - 1;
    const auto add_to = [&](Matrix& covariance) {
        covariance.topLeftCorner(nx, nx) += motion * model_.Q;
        covariance.bottomRightCorner(nl_, nl_) += colour * model_.Ql;
        for (int i = 0; i < nl_; ++i) covariance(nx + i, nx + i) += joint.opened()[i];
    };
    add_to(P_);
    if (lag_) {
        Q_now_ = Q_;
        add_to(Q_now_);
    }
    base_ += motion * HQH_ + colour * model_.Ql;
    for (int i = 0; i < nl_; ++i) base_(i, i) += joint.opened()[i];
}

bool Augmented::correct(const double* z, const int* present, int count, bool predicted, NoiseScale& noise, JointHypotheses* joint,
                        StepResult& out) {
    const int nz = model_.nz;
    expect();
    out.innovation.setConstant(std::numeric_limits<double>::quiet_NaN());
    for (int a = 0; a < count; ++a) out.innovation[present[a]] = z[present[a]] - H_.dot(present[a], X_.data());
    const Innovations seen{out.innovation.data(), base_, fresh_, zero_, zero_, present, count};
    if (joint) {
        if (!joint->update(seen, {HQH_, model_.Ql, predicted})) return false;
        enlarge(*joint);
    } else if (!noise.update(seen)) {
        return false;
    }
    const double* scale = joint ? joint->scale() : noise.scale();
    out.S = base_;
    for (int i = 0; i < nz; ++i) out.S(i, i) += scale[i] * model_.Qv(i, i);
    if (!model_.Qv_is_diagonal) add_shared_noise(scale, out.S);
    if (!nl_) base_ -= model_.Lambda0; // from here on H P H' only
    if (lag_ && predicted && !look_back(present, count, out)) return false;
    const bool good = sequential_ ? correct_by_channel(z, present, count, scale, out) : correct_at_once(present, count, out);
    if (lag_ && !predicted) { // the first sample has no previous step
        X_before_ = X_;
        P_before_ = P_;
    }
    return good;
}

bool Augmented::correct_by_channel(const double* z, const int* present, int count, const double* scale, StepResult& out) {
    *out.nis = 0;
    for (int a = 0; a < count; ++a) {
        const int i = present[a];
        const double r = scale[i] * model_.Qv(i, i) + (nl_ ? 0 : model_.Lambda0(i, i));
        H_.row_times(i, P_, g_); // h P
        const double s = H_.dot(i, g_) + r;
        if (!(s > 0)) return false;
        const double e = z[i] - H_.dot(i, X_.data());
        *out.nis += e * e / s;
        const double inverse_s = 1 / s;
        for (int j = 0; j < n_; ++j) K_[j] = g_[j] * inverse_s;
        for (int j = 0; j < n_; ++j) X_[j] += K_[j] * e;
        // (I - K h) P (I - K h)' + K r K' = M - (M h' - r K) K' with M = (I - K h) P: row by row in one sweep.
        for (int j = 0; j < n_; ++j) {
            double* __restrict row = P_.data() + j * n_;
            subtract(K_[j], g_, row);
            if (joseph_) subtract(H_.dot(i, row) - r * K_[j], K_, row);
        }
    }
    symmetrise(P_);
    return true;
}

void Augmented::add_shared_noise(const double* scale, Matrix& S) const {
    for (int i = 0; i < model_.nz; ++i)
        for (int j = 0; j < model_.nz; ++j)
            if (i != j) S(i, j) += std::sqrt(scale[i] * scale[j]) * model_.Qv(i, j);
}

bool Augmented::gather(const int* present, int count, const StepResult& out) {
    for (int a = 0; a < count; ++a)
        for (int b = 0; b < count; ++b) {
            S_(a, b) = out.S(present[a], present[b]);
            Rm_(a, b) = S_(a, b) - base_(present[a], present[b]);
        }
    return inverse_.factor(S_, count);
}

void Augmented::gain_from(const Matrix& V) {
    for (int i = 0; i < n_; ++i) inverse_.solve(V.data() + i * V.cols(), D_.data() + i * D_.cols());
}

bool Augmented::correct_at_once(const int* present, int count, StepResult& out) {
    *out.nis = 0;
    if (!gather(present, count, out)) return false;
    for (int a = 0; a < count; ++a) {
        R_[a] = out.innovation[present[a]];
        for (int j = 0; j < n_; ++j) V_(j, a) = HP_(present[a], j);
    }
    gain_from(V_);
    inverse_.solve(R_.data(), g_);
    for (int a = 0; a < count; ++a) *out.nis += R_[a] * g_[a];
    X_.noalias() += D_.leftCols(count) * R_.head(count);
    FP_ = P_;
    FP_.noalias() -= D_.leftCols(count) * V_.leftCols(count).transpose(); // (I - K H) P
    if (joseph_) {
        for (int j = 0; j < n_; ++j)
            for (int a = 0; a < count; ++a) V_(j, a) = H_.dot(present[a], FP_.data() + j * n_);
        V_.leftCols(count).noalias() -= D_.leftCols(count) * Rm_.topLeftCorner(count, count);
        FP_.noalias() -= V_.leftCols(count) * D_.leftCols(count).transpose();
    }
    P_ = FP_;
    symmetrise(P_);
    return true;
}

bool Augmented::look_back(const int* present, int count, const StepResult& out) {
    if (!gather(present, count, out)) return false;
    for (int a = 0; a < count; ++a) {
        V_.col(a).noalias() = P_before_ * HF_.row(present[a]).transpose();
        R_[a] = out.innovation[present[a]];
    }
    gain_from(V_);
    X_before_.noalias() += D_.leftCols(count) * R_.head(count);
    E_.setIdentity();
    for (int a = 0; a < count; ++a) {
        E_.noalias() -= D_.col(a) * HF_.row(present[a]);
        H_.row_times(present[a], Q_now_, g_);
        for (int b = 0; b < count; ++b) Rm_(a, b) += H_.dot(present[b], g_);
    }
    T_.noalias() = E_ * P_before_;
    P_before_.noalias() = T_ * E_.transpose();
    V_.leftCols(count).noalias() = D_.leftCols(count) * Rm_.topLeftCorner(count, count);
    P_before_.noalias() += V_.leftCols(count) * D_.leftCols(count).transpose();
    symmetrise(P_before_);
    return true;
}

} // namespace hnav
