// Put before every source of the mutated copy. HMUT: the number of the mutant that is on, hexadecimal; HMUT_REACHED: a file
// to which the numbers of those that were come by are added when the program ends.
#pragma once

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <type_traits>
#include <utility>

namespace hnav_mutants {

class Switch {
public:
    const unsigned long on = number();

    ~Switch() {
        const char* path = std::getenv("HMUT_REACHED");
        std::FILE* file = path ? std::fopen(path, "a") : nullptr;
        if (!file) return;
        for (int i = 0; i < count_; ++i) std::fprintf(file, "%08lx\n", reached_[i]);
        std::fclose(file);
    }
    void note(unsigned long k) { reached_[count_++] = k; }

private:
    static unsigned long number() {
        const char* text = std::getenv("HMUT");
        return text ? std::strtoul(text, nullptr, 16) : 0;
    }
    std::atomic<int> count_{0};
    unsigned long reached_[10000] = {};
};
inline Switch the_switch;

template <unsigned long k>
inline std::atomic<bool> reached{false};

// Expressions of matrices are evaluated: what is chosen from has one type.
template <class T, class = void>
struct Value {
    using type = T;
};
template <class T>
struct Value<T, std::void_t<decltype(std::declval<const T&>().eval())>> {
    using type = std::decay_t<decltype(std::declval<const T&>().eval())>;
};

} // namespace hnav_mutants

template <unsigned long k>
bool hnav_mutant() {
    using namespace hnav_mutants;
    if (!reached<k>.load(std::memory_order_relaxed) && !reached<k>.exchange(true)) the_switch.note(k);
    return the_switch.on == k;
}

// The operand as it is, or with its sign turned.
template <unsigned long k, class T>
auto hnav_flipped(const T& x) {
    using Value = typename hnav_mutants::Value<T>::type;
    return hnav_mutant<k>() ? Value(-x) : Value(x);
}

// The factor as it is, or its reciprocal; twice a matrix, and 1 for a whole number.
template <unsigned long k, class T>
auto hnav_inverted(const T& x) {
    if constexpr (std::is_floating_point_v<T>) {
        return hnav_mutant<k>() ? 1 / x : x;
    } else if constexpr (std::is_arithmetic_v<T>) {
        return hnav_mutant<k>() ? T(1) : x;
    } else {
        using Value = typename hnav_mutants::Value<T>::type;
        return hnav_mutant<k>() ? Value(2 * x) : Value(x);
    }
}
