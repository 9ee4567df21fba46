#include "attitude/hrekf/correction.hpp"

namespace hnav {

template class HrekfCorrectionBase<Scalar>;

} // namespace hnav
