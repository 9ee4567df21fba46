#include "ins_error/differenced.hpp"

#include <cmath>
#include <limits>

namespace hnav {

// E P E'. A function, because each product of matrices takes a second of compile time.
template <class Covariance>
static Small sandwich(const Small& E, const Covariance& P) {
    return E * P * E.transpose();
}

void Differences::prepare() {
    Hd.noalias() = model.H * model.A;
    Hd.noalias() -= model.An * model.H;
    HB.noalias() = model.H * model.B;
    C.noalias() = model.Q * model.H.transpose();
    driven.noalias() = model.H * C;
    driven += model.Ql;
}

int Differences::innovate(const double* z, const double* z_before, const double* u, const Vector& x, int* present,
                          Vector& nu) const {
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

Differenced::Differenced(MatrixArena& state, MatrixArena& work, const LinearModel& model, bool joseph, bool lag)
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

void Differenced::start() {
    x_ = model_.x0;
    P_ = model_.P0;
    v_before_.setZero();
    keep_before();
}

bool Differenced::correct_first(const double* z, const int* present, int count, NoiseScale& noise, StepResult& out) {
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
    const Small joint = joseph_ ? Small(sandwich(E, P_) + sandwich(K, R)) : Small(E * P_);
    P_ = joint;
    symmetrise(P_);
    keep_before();
    return true;
}

bool Differenced::step(const double* u, const double* z, const double* z_before, int* present, NoiseScale& noise,
                       StepResult& out) {
    const int nx = model_.nx, nz = model_.nz;
    const int count = d_.innovate(z, z_before, u, x_, present, out.innovation);
    // An V An' with the noise of the previous sample as scaled then; its diagonal is used by the adaptation.
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
        const Small joint = sandwich(E, P_) + sandwich(D, noise_of_mu);
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
        next = sandwich(E, P_) + sandwich(G, model_.Q) + sandwich(K, driving);
    } else {
        next = model_.A * P_ * model_.A.transpose() + model_.Q - K * T.transpose();
    }
    P_ = next;
    symmetrise(P_);
    return true;
}

double Differenced::scaled_v(int i, int j, const NoiseScale& noise) const {
    return i == j ? noise.scale()[i] * model_.Qv(i, i) : std::sqrt(noise.scale()[i] * noise.scale()[j]) * model_.Qv(i, j);
}

void Differenced::remember(const NoiseScale& noise) {
    for (int i = 0; i < model_.nz; ++i) v_before_[i] = noise.scale()[i] * model_.Qv(i, i);
}

void Differenced::keep_before() {
    if (!lag_) return;
    x_before_ = x_;
    P_before_ = P_;
}

bool Differenced::factor(const int* present, int count, const StepResult& out) {
    for (int a = 0; a < count; ++a)
        for (int b = 0; b < count; ++b) S_(a, b) = out.S(present[a], present[b]);
    return inverse_.factor(S_, count);
}

void Differenced::gain(const Small& T, const int* present, int count, Small& K) const {
    for (int a = 0; a < count; ++a)
        for (int b = 0; b < count; ++b) K.col(present[a]) += T.col(present[b]) * inverse_.inverse(b, a);
}

void Differenced::weigh(const int* present, int count, StepResult& out, const Small& K, Vector& estimate) const {
    *out.nis = 0;
    for (int a = 0; a < count; ++a) {
        estimate += K.col(present[a]) * out.innovation[present[a]];
        for (int b = 0; b < count; ++b)
            *out.nis += out.innovation[present[a]] * inverse_.inverse(a, b) * out.innovation[present[b]];
    }
}

} // namespace hnav
