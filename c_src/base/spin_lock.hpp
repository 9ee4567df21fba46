// A lock for short or rare sections from the header <atomic> alone: the library needs no C++ runtime library.
#pragma once

#include <atomic>

#ifdef _WIN32
#define WIN32_LEAN_AND_MEAN
#define NOMINMAX
#include <windows.h>
#else
#include <sched.h>
#endif

namespace hnav {

class SpinLock {
public:
    class Held {
    public:
        explicit Held(SpinLock& lock) : lock_(lock) {
            while (lock_.taken_.test_and_set(std::memory_order_acquire)) give_way();
        }
        Held(const Held&) = delete;
        Held& operator=(const Held&) = delete;
        ~Held() { lock_.taken_.clear(std::memory_order_release); }

    private:
        static void give_way() {
#ifdef _WIN32
            SwitchToThread();
#else
            sched_yield();
#endif
        }

        SpinLock& lock_;
    };

private:
    std::atomic_flag taken_ = ATOMIC_FLAG_INIT;
};

} // namespace hnav
