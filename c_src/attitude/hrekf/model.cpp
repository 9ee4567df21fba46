#include "attitude/hrekf/model.hpp"

#include "attitude/hrekf/bias_walk.hpp"
#include "attitude/hrekf/covariance.hpp"
#include "attitude/hrekf/flow.hpp"
#include "attitude/hrekf/jump.hpp"
#include "attitude/hrekf/outputs.hpp"
#include "attitude/hrekf/recovery.hpp"
#include "attitude/hrekf/start.hpp"

namespace hnav {

template class HrekfModelOf<Scalar>; // the members that the files above define

} // namespace hnav
