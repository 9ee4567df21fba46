// Controls at rest: the built-in square waves excite the aircraft.
#include "adapter/example_input.hpp"
#include "aircraft/data.hpp"

#include <initializer_list>

namespace hnav::fmu {

void write_example_input(FILE* file) {
    std::fputs("time", file);
    for (const aircraft::Quantity& control : aircraft::controls) std::fprintf(file, ",command.%s", control.name);
    for (const int t : {0, 20}) {
        std::fprintf(file, "\n%d", t);
        for (int j = 0; j < aircraft::nu; ++j) std::fputs(",0", file);
    }
    std::fputs("\n", file);
}

} // namespace hnav::fmu
