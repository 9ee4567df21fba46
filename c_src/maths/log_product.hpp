// The logarithm of a product of many positive factors: multiplies while the product fits into a double, then calls log once.
#pragma once

#include <cmath>

namespace hnav {

class LogProduct {
public:
    void times(double factor) {
        product_ *= factor;
        if (product_ > 1e-100 && product_ < 1e100) return;
        log_ += std::log(product_);
        product_ = 1;
    }

    double log() const { return log_ + std::log(product_); }

private:
    double product_ = 1, log_ = 0;
};

} // namespace hnav
