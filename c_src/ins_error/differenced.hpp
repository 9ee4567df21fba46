// Measurement differencing: z(k) - An z(k-1) does not contain lambda, only its driving noise.
//
//   mu(k) = z(k) - An z(k-1) = Hd x(k-1) + H B u(k-1) + xi,  Hd = H A - An H
//   xi = H G w(k-1) + Bn U(k-1) + v(k) - An v(k-1),  R = H G Qw G'H' + Bn QU Bn' + Qv + An Qv An',  C = G Qw G'H'
//
// xi is correlated with w(k-1) (covariance C) and, when v is not zero, with its previous value: E[xi(k) xi(k-1)'] = -An Qv.
#pragma once

#include "ins_error/augmented.hpp"

namespace hnav {

// The model of both differencing filters.
struct Differences {
    Differences(MatrixArena& work, const LinearModel& of)
        : model(of),
          Hd(work.matrix(model.nz, model.nx)),
          HB(work.matrix(model.nz, model.nu)),
          C(work.matrix(model.nx, model.nz)),
          driven(work.matrix(model.nz, model.nz)) {}

    void prepare();

    // mu - HB u - Hd x in the channels with a difference; `present` is their number.
    int innovate(const double* z, const double* z_before, const double* u, const Vector& x, int* present, Vector& nu) const;

    const LinearModel& model;
    Matrix Hd, HB, C;
    Matrix driven; // R without v: H G Qw G'H' + Bn QU Bn'
};

// The paper's filter as printed, (12)-(16), and its adaptation, up to (24). Step k uses mu(k) = z(k+1) - An z(k), so
// the estimate is of the step before the newest measurement; z(0) is not used.
//
//   K = (P Hd' + C) Omega*^-1,  P <- P - K Omega K',  Omega = Hd P Hd' + R + Hd C + C'Hd'
//   Omega*: with S* R for R,  S* = diag(max(1, S_ii)),  S = [(1/M) sum Delta Delta' - Hd P Hd' - Hd C - C'Hd'] R^-1
//
// Its errors: xi is not white; C belongs in the next prediction; R also holds process noise; max(1, .) is
// biased; the adaptation changes K but not P. It serves for comparison.
class Printed {
public:
    Printed(MatrixArena& state, MatrixArena& work, const LinearModel& model, int window);

    void prepare();

    void start();

    const double* scale() const { return scale_.data(); }
    const Vector& shown_x() const { return x_; }
    const Matrix& shown_P() const { return P_; }

    // first: x0 is already the prior of the step of mu. False: Omega is singular.
    bool step(const double* u, const double* z, const double* z_before, bool first, int* present, StepResult& out);

private:
    void predict();

    // Channels that are missing together have no product in the window; its expectation replaces it.
    void match(const Vector& delta);

    bool correct(const int* present, int count, StepResult& out);

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

// The corrected form: estimate of the step of the newest measurement, C in the next prediction, z(0) used. Exact when
// v = 0; otherwise xi is treated as white, which differencing cannot avoid without more states.
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
    Differenced(MatrixArena& state, MatrixArena& work, const LinearModel& model, bool joseph, bool lag);

    void prepare() { d_.prepare(); }

    void start();

    // z(0) is the only sample that measures x itself and not its change.
    bool correct_first(const double* z, const int* present, int count, NoiseScale& noise, StepResult& out);

    bool step(const double* u, const double* z, const double* z_before, int* present, NoiseScale& noise, StepResult& out);

    const Vector& shown_x() const { return lag_ ? x_before_ : x_; }
    const Matrix& shown_P() const { return lag_ ? P_before_ : P_; }

private:
    double scaled_v(int i, int j, const NoiseScale& noise) const;

    void remember(const NoiseScale& noise);

    void keep_before();

    bool factor(const int* present, int count, const StepResult& out);

    // Columns of the missing channels stay zero.
    void gain(const Small& T, const int* present, int count, Small& K) const;

    // estimate += K nu, and nu' S^-1 nu.
    void weigh(const int* present, int count, StepResult& out, const Small& K, Vector& estimate) const;

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
