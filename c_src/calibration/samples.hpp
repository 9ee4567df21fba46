// The samples of a calibration: without missing rows, field centred and scaled, forces tested.
#pragma once

#include "calibration/robust.hpp"
#include "maths/rotation.hpp"

#include <cstdlib>
#include <limits>
#include <memory>

namespace hnav {

// Normalised samples and a few numbers for each, in one block.
class Samples {
public:
    explicit Samples(Index n)
        : block_(static_cast<double*>(std::calloc(static_cast<std::size_t>(n) + 1, columns * sizeof(double)))), n_(n) {}
    explicit operator bool() const { return block_ != nullptr; }

    Columns z() const { return Columns(at(0), 3, count); }  // field, centred and scaled
    Columns u() const { return Columns(at(3), 3, count); }  // field, corrected to length 1
    Columns a() const { return Columns(at(6), 3, count); }  // direction of force
    Values trust() const { return Values(at(9), count); }   // 1 where the force may be gravity
    Values weight() const { return Values(at(10), count); } // of the field
    Values residual() const { return Values(at(11), count); }
    Values angle() const { return Values(at(12), count); }  // residual of the dip
    Values angle_weight() const { return Values(at(13), count); }
    Values scratch() const { return Values(at(14), count); }

    // Of a sample, what is known before the fit.
    void move(Index from, Index to) {
        z().col(to) = z().col(from).eval();
        a().col(to) = a().col(from).eval();
        trust()[to] = trust()[from];
    }

    Index count = 0; // rows with a field

private:
    static constexpr std::size_t columns = 15;
    double* at(Index column) const { return block_.get() + column * n_; }

    struct Free {
        void operator()(double* p) const { std::free(p); }
    };
    std::unique_ptr<double[], Free> block_;
    Index n_;
};

// Copies the rows with a field.
inline void gather(Index n, const double* field, const double* force, Samples& s) {
    for (Index i = 0; i < n; ++i) s.count += !std::isnan(field[3 * i]);
    Columns z = s.z(), a = s.a();
    Index k = 0;
    for (Index i = 0; i < n; ++i) {
        if (std::isnan(field[3 * i])) continue;
        z.col(k) = Vector3(field + 3 * i);
        a.col(k) = force ? Vector3(force + 3 * i) : Vector3::Constant(std::numeric_limits<double>::quiet_NaN());
        ++k;
    }
}

// Omits rows that no field at the place explains, such as the overflow of a chip: one of them among thousands would
// determine the mean, the scale and the plane of all. Others are left to the weights of the fit.
inline void drop_wild(Samples& s) {
    constexpr double share = 0.99;  // chosen: a sensor at rest for nearly the whole recording still has its motion beyond it
    constexpr double farthest = 10; // chosen: points of an ellipsoid are at most two long axes apart
    if (s.count == 0) return;
    const Columns z = s.z();
    Values distance = s.residual(), scratch = s.scratch();
    Vector3 middle;
    for (int k = 0; k < 3; ++k) {
        scratch = z.row(k).transpose();
        middle[k] = median(scratch.data(), s.count);
    }
    for (Index i = 0; i < s.count; ++i) scratch[i] = distance[i] = (z.col(i) - middle).norm();
    const double limit = farthest * quantile(scratch.data(), s.count, share);
    Index kept = 0;
    for (Index i = 0; i < s.count; ++i)
        if (!(distance[i] > limit)) s.move(i, kept++);
    s.count = kept;
}

// z <- (z - middle) / scale, with the mean and the root mean square distance from it.
inline void normalise(Samples& s, Vector3* middle, double* scale) {
    Columns z = s.z();
    middle->setZero();
    for (Index i = 0; i < s.count; ++i) *middle += z.col(i) / static_cast<double>(s.count);
    double mean_square = 0;
    for (Index i = 0; i < s.count; ++i) mean_square += (z.col(i) - *middle).squaredNorm() / static_cast<double>(s.count);
    *scale = std::sqrt(mean_square);
    for (Index i = 0; i < s.count; ++i) z.col(i) = (z.col(i) - *middle) / *scale;
}

// Gravity has one length: a force of another length contains acceleration and is rejected.
inline void choose_forces(double tolerance, Samples& s) {
    Columns a = s.a();
    Values trust = s.trust(), scratch = s.scratch();
    Index known = 0;
    for (Index i = 0; i < s.count; ++i)
        if (a.col(i).norm() > 0) scratch[known++] = a.col(i).norm(); // false for NaN too
    const double gravity = median(scratch.data(), known);
    for (Index i = 0; i < s.count; ++i) {
        const double norm = a.col(i).norm();
        trust[i] = norm > 0 && std::fabs(norm - gravity) <= tolerance * gravity;
        if (trust[i] > 0) a.col(i) /= norm;
    }
}

// Omits samples without a new attitude: neither field nor gravity has changed since the last one kept. Otherwise a sensor
// at rest for half of the recording would determine every median.
inline void drop_rests(double step, Samples& s) {
    const Columns z = s.z(), a = s.a();
    const Values trust = s.trust();
    Vector3 last_a = Vector3::Zero(); // of the newest force that was kept
    Index kept = 0;
    for (Index i = 0; i < s.count; ++i) {
        const bool field_moved = kept == 0 || (z.col(i) - z.col(kept - 1)).norm() > step;
        const bool force_moved = trust[i] > 0 && (a.col(i) - last_a).norm() > step;
        if (!field_moved && !force_moved) continue;
        if (trust[i] > 0) last_a = a.col(i);
        s.move(i, kept++);
    }
    s.count = kept;
}

} // namespace hnav
