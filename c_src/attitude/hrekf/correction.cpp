#include "attitude/hrekf/correction.hpp"

namespace hnav {

template class HrekfCorrectionBase<double>;

} // namespace hnav
