// Five seconds of a climb at 20 m/s.
#include "adapter/example_input.hpp"

namespace hnav::fmu {

void write_example_input(FILE* file) {
    std::fputs("time,truth.height\n", file);
    for (int k = 0; k <= 500; ++k) std::fprintf(file, "%.2f,%.9g\n", 0.01 * k, 100 + 0.2 * k);
}

} // namespace hnav::fmu
