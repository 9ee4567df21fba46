// FMUs that live in this process. Instances of one FMU share what is static in its library, and some lose events through that: so each
// has a copy of the file of its own, and before a second one is used it is tried whether two leave each other alone.
#pragma once

#include "observer/fmu_plant.hpp"

namespace hnav::observer {

// Opens an FMU beside those that live; takes from it what the plan leaves to it. Null: why says it.
FmuPlant* open_beside_others(const char* folder, Plan& plan, double start_s, Refusal& why);

} // namespace hnav::observer
