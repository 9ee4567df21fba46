// x^2, where a name says more than the product.
#pragma once

namespace hnav {

template <class R>
constexpr R square(R x) {
    return x * x;
}

} // namespace hnav
