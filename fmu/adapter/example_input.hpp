#pragma once

#include <cstdio>

namespace hnav::fmu {

// Writes a short input signal for the FMU as CSV with a header of variable names, time first; each FMU has its own.
void write_example_input(FILE* file);

} // namespace hnav::fmu
