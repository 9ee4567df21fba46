// What a filter answers to a sample or to a time.
#pragma once

namespace hnav {

enum class Outcome { ok, late, full, backwards, diverged };

} // namespace hnav
