// Results of pushing a sample or advancing to a time.
#pragma once

namespace hnav {

enum class Outcome { ok, late, full, backwards, diverged };

} // namespace hnav
