// The Kalman filter on X = [x; lambda]: coloured errors are states. Optimal for any v.
//
//   F = diag(A, An), Ha = [H I], R = Qv (scaled by the adaptation)
//   predict   X = F X + [B; 0] u,  P = F P F' + diag(G Qw G', Bn QU Bn')
//   correct   K = P Ha' S^-1,  S = Ha P Ha' + R,  P = (I - K Ha) P (I - K Ha)' + K R K' (Joseph)
//   lag one   x(k-1|k) = x(k-1|k-1) + D nu,  D = P(k-1|k-1) F' Ha' S^-1
//
//   A. E. Bryson, D. E. Johansen, Linear filtering for time-varying systems using measurements containing colored noise,
//   IEEE Trans. Automatic Control 10(1), 1965. B. D. O. Anderson, J. B. Moore, Optimal Filtering, 1979, 7.3 (fixed lag).
//
// Without the states lambda the class is the plain Kalman filter, which treats lambda as white noise of covariance
// Lambda0: R = Qv + Lambda0.
#pragma once

#include "ins_error/joint_hypotheses.hpp"
#include "ins_error/linear_model.hpp"
#include "maths/sparse_rows.hpp"

namespace hnav {

// Results of the last step.
struct StepResult {
    StepResult(MatrixArena& state, int nz) : innovation(state.vector(nz)), S(state.matrix(nz, nz)), nis(state.doubles(1)) {}
    Vector innovation; // NaN in a missing channel
    Matrix S;
    double* nis;
};

class Augmented {
public:
    Augmented(MatrixArena& state, MatrixArena& work, const LinearModel& model, bool with_colour, bool joseph, bool lag);

    // After the model changed.
    void prepare();

    void start();

    void predict(const double* u);

    // present: the channels of z with a sample; predicted: after predict, so that lag one has a previous step.
    // joint: null for another noise scaling. False: S is not positive definite.
    bool correct(const double* z, const int* present, int count, bool predicted, NoiseScale& noise, JointHypotheses* joint,
                 StepResult& out);

    // The estimate of the outputs: of this step, or of the previous one.
    const Vector& shown_X() const { return lag_ ? X_before_ : X_; }
    const Matrix& shown_P() const { return lag_ ? P_before_ : P_; }

private:
    // Scalar corrections one after the other equal the joint one when R is diagonal, and need no factorisation.
    bool correct_by_channel(const double* z, const int* present, int count, const double* scale, StepResult& out);

    // H P H' and, in the plain form, Lambda0.
    void expect();

    // P with the process noise, and the variances of lambda, of the hypotheses.
    void enlarge(const JointHypotheses& joint);

    // The rest of a full Qv, scaled as standard deviations are, so that it stays a covariance.
    void add_shared_noise(const double* scale, Matrix& S) const;

    // row -= factor * other
    void subtract(double factor, const double* __restrict other, double* __restrict row) const {
        for (int k = 0; k < n_; ++k) row[k] -= factor * other[k];
    }

    // S and R of the present channels, S factorised.
    bool gather(const int* present, int count, const StepResult& out);

    // D = V S^-1
    void gain_from(const Matrix& V);

    bool correct_at_once(const int* present, int count, StepResult& out);

    // The newest innovation corrects the estimate before it, in Joseph's form: with E = I - D Ha F,
    // P(k-1|k) = E P E' + D (Ha Q Ha' + R) D'.
    bool look_back(const int* present, int count, const StepResult& out);

    const LinearModel& model_;
    const int nl_, n_;
    const bool joseph_, lag_;
    bool sequential_ = true;
    Vector X_;
    Matrix P_;
    Vector X_before_;
    Matrix P_before_;
    SparseRows F_, H_;
    Matrix Q_, Q_now_, HQH_, HF_, FP_, PF_, HP_, base_;
    Vector R_;
    double *zero_, *fresh_, *g_, *K_, *m_;
    Matrix S_, Rm_, V_, D_, E_, T_;
    LowerInverse inverse_;
};

} // namespace hnav
