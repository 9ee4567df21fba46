// The constant part of a sensor's error: reading = matrix (input + before) + after +
// drift t. Spreads of the datasheet are drawn once from the seed.
#pragma once

#include "maths/rotation.hpp"
#include "simulation/random.hpp"

namespace hnav {

struct LinearError {
    Matrix3 matrix = Matrix3::Identity();
    Vector3 before = Vector3::Zero(); // hard iron
    Vector3 after = Vector3::Zero();  // bias
    Vector3 drift = Vector3::Zero();  // of the bias, per second

    Vector3 operator()(const Vector3& input, double t_s) const { return matrix * (input + before) + after + drift * t_s; }
};

// Random numbers of one sensor, each with its own index: switching off a spread does not change the others.
class Constants {
public:
    Constants(std::uint64_t seed, std::uint64_t stream) : random_(seed, stream) {}

    Vector3 vector(std::uint64_t place, double sigma) const {
        return sigma * Vector3(random_.normal(16 * place), random_.normal(16 * place + 1), random_.normal(16 * place + 2));
    }
    Matrix3 matrix(std::uint64_t place, double sigma) const {
        Matrix3 m;
        for (int i = 0; i < 9; ++i) m(i / 3, i % 3) = sigma * random_.normal(16 * place + static_cast<unsigned>(i));
        return m;
    }

private:
    RandomStream random_;
};

// 1 + scale factor on the diagonal, misalignment xy xz yx yz zx zy beside it: of y seen in x, ...
inline Matrix3 scale_and_misalignment(const Vector3& scale, const double* misalignment) {
    Matrix3 m = Matrix3::Identity();
    for (int i = 0, k = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) m(i, j) += i == j ? scale[i] : misalignment[k++];
    return m;
}

} // namespace hnav
