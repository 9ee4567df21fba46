// A motor torque that alternates for six seconds.
#include "adapter/example_input.hpp"

namespace hnav::fmu {

void write_example_input(FILE* file) {
    std::fputs("time,drive\n", file);
    for (int k = 0; k <= 300; ++k) std::fprintf(file, "%.9g,%d\n", 0.02 * k, k / 25 % 2 ? -2 : 2);
}

} // namespace hnav::fmu
