// Hosts may trap invalid floating-point operations (gfortran -ffpe-trap=invalid). In the library NaN is a sample that is missing, and an ordered
// comparison with it is such an operation: traps are masked within a call, and the host's state is restored after it.
#pragma once

#include <cfenv>

#if defined(__SSE2__) || defined(_M_X64)
#include <xmmintrin.h>
#endif

namespace hnav::fmu {

class WithoutFloatTraps {
public:
    WithoutFloatTraps() : held_(host_traps() && std::feholdexcept(&host_) == 0) {}
    ~WithoutFloatTraps() {
        if (held_) std::fesetenv(&host_);
    }
    WithoutFloatTraps(const WithoutFloatTraps&) = delete;
    WithoutFloatTraps& operator=(const WithoutFloatTraps&) = delete;

private:
    // Reading one register costs nothing beside feholdexcept.
    static bool host_traps() {
#if defined(__SSE2__) || defined(_M_X64)
        return _mm_getcsr() % 0x2000 / 0x80 != 0x3f; // a mask for each of the six exceptions
#else
        return true;
#endif
    }

    std::fenv_t host_;
    bool held_;
};

} // namespace hnav::fmu
