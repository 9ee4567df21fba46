// x^2, for readable expressions.
#pragma once

namespace hnav {

template <class R>
constexpr R square(R x) {
    return x * x;
}

} // namespace hnav
