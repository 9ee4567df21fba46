// Joint moments of X now and X at the instant before, by which a smoother goes back (smoother.hpp). Each part has, relative to the end of
// the instant before, of X there: how far its mean o is from that of the whole estimate, its covariance O, and its covariance C with X now.
//
//     flow, event   C = C Phi',  C = C Xi'            noise and what is held leave O and C
//     cut           with c = C g / sd:  o += l c,  O -= q c c',  C -= q c k'                  see hypotheses.cpp for k, l, q
//     correction    with c = C h / S:   o += c nu,  O -= c S c',  C -= c (P h)'
//     merge         by moments
//     points        a point at distance L xi of the mean has o + M xi with M = C L'^-1, and O - M M'
//
// Events, splits and samples thus act on X then as they act on X now, and the smoother needs no Jacobian of its own. Without a smoother
// nothing happens here.
#include "estimation/truncation.hpp"
#include "observer/observer_model.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hnav::observer {
namespace {

// The three of a part or of a copy.
template <class Number>
struct View {
    View(Number* at, int N) : o(at), O(o + N), C(O + Layout::triangle(N)) {}
    Number *o, *O, *C;
};

// Upper triangle minus a a' times a factor.
void take_square(double* upper, int n, double factor, const double* a) {
    for (int i = 0; i < n; ++i)
        for (int j = i; j < n; ++j) *upper++ -= factor * a[i] * a[j];
}

void take_product(double* C, int n, double factor, const double* a, const double* b) {
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) C[i * n + j] -= factor * a[i] * b[j];
}

} // namespace

// An interval begins: the instant before is the newest.
void Model::open_joint(State& s) const {
    const Layout& at = layout();
    const int N = problem_->N;
    if (!smooths() || std::exchange(s.x()[at.closed], 0) == 0) return;
    double *mean = work_->joint_row, *X = mean + N;
    std::fill_n(mean, N, 0.0);
    for (int i = 0; i < parts_of(s); ++i) {
        const double* part = part_of(s, i);
        expected_uncut(part, part, X);
        for (int j = 0; j < N; ++j) mean[j] += part[at.weight] * X[j];
    }
    for (int i = 0; i < parts_of(s); ++i) {
        double* part = part_of(s, i);
        const View joint(part + at.joint, N);
        expected_uncut(part, part, X);
        for (int j = 0; j < N; ++j) joint.o[j] = parts_of(s) > 1 ? X[j] - mean[j] : 0;
        std::copy_n(part + at.P, Layout::triangle(N), joint.O);
        unpack_upper(part + at.P, N, 1, joint.C);
    }
}

// C = C M' of the first rows of M; the other columns stay.
void Model::move_joint(const double* M, int rows, double* part) const {
    if (!smooths()) return;
    const int N = problem_->N;
    double *row = View(part + layout().joint, N).C, *before = work_->joint_row;
    for (int r = 0; r < N; ++r, row += N) {
        std::copy_n(row, N, before);
        times_rows(M, rows, N, before, row);
    }
}

// A sensor, before it corrects P.
void Model::correct_joint(double* part, const double* P, const double* h, double innovation, double variance) const {
    if (!smooths()) return;
    const int N = problem_->N;
    const View joint(part + layout().joint, N);
    double *Ph = work_->joint_row, *c = Ph + N, S = variance;
    times_rows(P, N, N, h, Ph);
    times_rows(joint.C, N, N, h, c);
    for (int i = 0; i < N; ++i) S += h[i] * Ph[i];
    for (int i = 0; i < N; ++i) c[i] /= S;
    for (int i = 0; i < N; ++i) joint.o[i] += c[i] * innovation;
    take_square(joint.O, N, S, c);
    take_product(joint.C, N, 1, c, Ph);
}

// The part has one side of the guard of the event e: its mean moves by l k, its covariance loses q k k'.
void Model::cut_joint(const Passage& e, const double* k, double sd, double l, double q, double* part) const {
    if (!smooths()) return;
    const int N = problem_->N;
    std::copy_n(e.joint, layout().joint_numbers, part + layout().joint);
    const View joint(part + layout().joint, N);
    double* c = work_->joint_row;
    times_rows(joint.C, N, N, e.gradient, c);
    for (int i = 0; i < N; ++i) c[i] /= sd;
    for (int i = 0; i < N; ++i) joint.o[i] += l * c[i];
    take_square(joint.O, N, q, c);
    take_product(joint.C, N, q, c, k);
}

// Of both parts, whose means are X and Y, to the workspace.
void Model::merge_joint(const double* part, const double* other, double share, const double* X, const double* Y) const {
    if (!smooths()) return;
    const Layout& at = layout();
    const int N = problem_->N;
    std::copy_n(part + at.joint, at.joint_numbers, work_->joint_merged);
    const View a(work_->joint_merged, N);
    const View b(other + at.joint, N);
    const double both = share * (1 - share);
    for (int i = 0; i < N; ++i)
        for (int j = 0; j < N; ++j) {
            double& C = a.C[i * N + j];
            C += share * (b.C[i * N + j] - C) + both * (b.o[i] - a.o[i]) * (Y[j] - X[j]);
        }
    double* O = a.O;
    const double* Q = b.O;
    for (int i = 0; i < N; ++i)
        for (int j = i; j < N; ++j, ++O, ++Q) *O += share * (*Q - *O) + both * (b.o[i] - a.o[i]) * (b.o[j] - a.o[j]);
    for (int i = 0; i < N; ++i) a.o[i] += share * (b.o[i] - a.o[i]);
}

// ------------------------------------------------------------------------------------------------ points

// P is taken apart into columns k = P d / sd, P = sum k k', each of a unit variable. Column c of M is how the earlier state depends on that
// variable; the joint in the workspace loses what it explains.
void Model::condition_joint(const double* k, int c, const double* d, double sd) const {
    if (!smooths()) return;
    const int N = problem_->N;
    const View joint(work_->joint, N);
    double* M = work_->joint_root + c * N;
    times_rows(joint.C, N, N, d, M);
    for (int i = 0; i < N; ++i) M[i] /= sd;
    take_square(joint.O, N, 1, M);
    take_product(joint.C, N, 1, M, k);
}

// A point at these distances along the columns, in units of them.
void Model::place_point_joint(const double* distances, int columns, double* point) const {
    if (!smooths()) return;
    const int N = problem_->N;
    std::copy_n(work_->joint, layout().joint_numbers, point + layout().joint);
    const View joint(point + layout().joint, N);
    std::fill_n(joint.C, N * N, 0.0);
    for (int c = 0; c < columns; ++c)
        for (int i = 0; i < N; ++i) joint.o[i] += distances[c] * work_->joint_root[c * N + i];
}

// M of the triangular root L, by rows.
void Model::begin_cubature_joint(const double* L, const double* part) const {
    if (!smooths()) return;
    const int N = problem_->N;
    const double* C = part + layout().joint + N + Layout::triangle(N);
    for (int r = 0; r < N; ++r)
        for (int c = 0; c < N; ++c) {
            double *m = work_->joint_root + r * N, sum = C[r * N + c];
            for (int k = 0; k < c; ++k) sum -= m[k] * L[c * N + k];
            m[c] = L[c * N + c] > 0 ? sum / L[c * N + c] : 0;
        }
}

// points: pairs on both sides of the mean, propagated.
void Model::end_cubature_joint(const double* points, double* part) const {
    if (!smooths()) return;
    const int N = problem_->N;
    const View joint(part + layout().joint, N);
    const double factor = 0.5 / std::sqrt(N);
    for (int r = 0; r < N; ++r)
        for (int j = 0; j < N; ++j) {
            double sum = 0;
            for (int c = 0; c < N; ++c)
                sum += work_->joint_root[r * N + c] * (points[2 * c * N + j] - points[(2 * c + 1) * N + j]);
            joint.C[r * N + j] = factor * sum;
        }
}

// ------------------------------------------------------------------------------------------------ answers

void Model::joint_moments(const State& s, const Joint& to) const {
    const Layout& at = layout();
    const int N = problem_->N;
    for (double* mean : {to.X, to.moved}) std::fill_n(mean, N, 0.0);
    for (double* matrix : {to.P, to.origin_P, to.C}) std::fill_n(matrix, N * N, 0.0);
    double* X = work_->joint_row;
    const auto each = [&](auto&& add) {
        for (int i = 0; i < parts_of(s); ++i) {
            const double* part = part_of(s, i);
            add(part[at.weight], part, part + at.joint, expected_uncut(part, part, X));
        }
    };
    each([&](double w, const double*, const double* o, const double* of) {
        for (int j = 0; j < N; ++j) {
            to.X[j] += w * of[j];
            to.moved[j] += w * o[j];
        }
    });
    each([&](double w, const double* part, const double* o, const double* of) {
        const double *P = part + at.P, *O = o + N, *C = O + Layout::triangle(N);
        for (int j = 0; j < N; ++j)
            for (int k = 0; k < N; ++k) {
                to.C[j * N + k] += w * (C[j * N + k] + (o[j] - to.moved[j]) * (of[k] - to.X[k]));
                if (k < j) continue;
                to.P[j * N + k] += w * (*P++ + (of[j] - to.X[j]) * (of[k] - to.X[k]));
                to.origin_P[j * N + k] += w * (*O++ + (o[j] - to.moved[j]) * (o[k] - to.moved[k]));
            }
    });
    for (double* matrix : {to.P, to.origin_P})
        for (int j = 0; j < N; ++j)
            for (int k = 0; k < j; ++k) matrix[j * N + k] = matrix[k * N + j];
}

void Model::finish(double* X, double* P) const {
    if (!problem_->bounded) return;
    truncate(problem_->N, problem_->low, problem_->high, X, P);
    leave_logarithms(X, P);
}

} // namespace hnav::observer
