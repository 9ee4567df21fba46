// For an FMU without inputs.
#include "adapter/example_input.hpp"

namespace hnav::fmu {

void write_example_input(FILE*) {}

} // namespace hnav::fmu
