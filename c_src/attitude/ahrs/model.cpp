#include "attitude/ahrs/model.hpp"

#include "attitude/ahrs/covariance.hpp"
#include "attitude/ahrs/flow.hpp"
#include "attitude/ahrs/jump.hpp"
#include "attitude/ahrs/outputs.hpp"
#include "attitude/ahrs/preintegration.hpp"
#include "attitude/ahrs/recovery.hpp"
#include "attitude/ahrs/start.hpp"

namespace hnav {

template class AhrsModelOf<Scalar>; // the members that the files above define

} // namespace hnav
