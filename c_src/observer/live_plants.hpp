// FMUs in this process. Instances of one FMU share the static variables of its library, and some lose events through that. Each
// therefore loads its own copy of the file, and before a second one is used a trial checks that they do not disturb each other.
#pragma once

#include "observer/fmu_plant.hpp"

namespace hnav::observer {

// Opens an FMU beside the existing ones; takes values from it where the plan has none. Null: why has the reason.
FmuPlant* open_beside_others(const char* folder, Plan& plan, double start_s, Refusal& why);

} // namespace hnav::observer
