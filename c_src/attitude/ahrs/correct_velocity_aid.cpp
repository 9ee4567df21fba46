// Correction by a velocity aid: its horizontal part, north and east. An acceleration that it explains no longer tilts the horizon.
#include "attitude/ahrs/correct_aid.hpp"

namespace hnav {

using Model = AhrsModelOf<Scalar>;

template <>
template <>
struct Model::Aid<HNAV_SENSOR_VELOCITY> {
    static void correct(const Model&, State& s, Correction& c, const Event& event) {
        const double* told = event.value[HNAV_SENSOR_VELOCITY];
        const Vector3R before = c.rotation_variances();
        const Eigen::Matrix<Scalar, errors, 2> PHt = columns<2>(c.P, velocity);
        Matrix2R S = block<2, 2>(c.P, velocity, velocity);
        S.diagonal().array() += Scalar(told[2] * told[2]);
        const Vector2R estimate = Vector2R(s.velocity[0], s.velocity[1]) + segment<2>(c.error, velocity);
        const Vector2R innovation = Vector2R(Scalar(told[0]), Scalar(told[1])) - estimate;

        InnovationOf<Scalar>& i = s.innovation[HNAV_SENSOR_VELOCITY];
        i = {};
        i.t_s = event.t_s;
        i.dimension = 2;
        Eigen::Map<Vector2R>(i.value) = innovation;
        i.S[0] = S(0, 0);
        i.S[1] = i.S[3] = S(0, 1);
        i.S[4] = S(1, 1);
        i.nis = normalised_square<2, Scalar>(S, innovation);

        condition<2, 0>(c, PHt, S, innovation);
        s.information.gain_tilt(before, c.rotation_variances());
    }
};

template void Model::correct_by<Model::Aid<HNAV_SENSOR_VELOCITY>>(State& s, Correction& c, const Event& event) const;

} // namespace hnav
