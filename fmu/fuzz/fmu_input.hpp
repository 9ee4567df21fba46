// Shared by the targets of both FMI versions: the token of this FMU, references and values from the fuzzer, and a logger that
// records whether a failure was explained.
#pragma once

#include "adapter/instance.hpp"
#include "input.hpp"
#include "invariant.hpp"

#include <type_traits>
#include <vector>

namespace fuzz {

// The table of the FMU that was linked, and the token that its description carries.
struct Description {
    hnav::fmu::Table table;
    int nx = 0;
    char token[64] = "";

    Description() {
        hnav::fmu::Model* model = hnav::fmu::make_model();
        HOLDS(model);
        model->describe(table);
        nx = hnav::fmu::model_info.states.count;
        delete model;
        hnav::fmu::Instance::format_token(table.token(hnav::fmu::model_info.arrays), token, sizeof token);
    }
};

inline const Description& description() {
    static const Description d;
    return d;
}

inline int messages = 0;

// Mostly variables of the type that the call sets, so that calls succeed; otherwise any number.
inline unsigned reference(Input& in, hnav::fmu::Type type) {
    const hnav::fmu::Table& table = description().table;
    const int first = in.byte() * 256 + in.byte();
    if (first % 32 == 31) return static_cast<unsigned>(in.byte()) << 24 | in.byte();
    for (int k = 0; k < table.size(); ++k) {
        const int row = (first + k) % table.size();
        if (table[row].type == type) return static_cast<unsigned>(row) + 1; // all variables are scalars
    }
    return 0;
}

// A call that sets up to four variables.
template <class T>
struct Setting {
    unsigned references[4];
    T values[4];
    std::size_t n;

    Setting(Input& in, hnav::fmu::Type type) : n(static_cast<std::size_t>(in.choice(5))) {
        for (std::size_t i = 0; i < n; ++i) {
            references[i] = reference(in, type);
            if constexpr (std::is_same_v<T, double>) values[i] = in.number();
            else values[i] = static_cast<T>(in.flag() ? static_cast<int>(in.byte() * 0x1010101u) : in.choice(4));
        }
    }
};

// The arguments of GetDirectionalDerivative.
struct Direction {
    unsigned unknowns[3], knowns[3];
    double seed[3], sensitivity[3];
    std::size_t n, k;

    explicit Direction(Input& in) {
        n = static_cast<std::size_t>(in.choice(4));
        k = static_cast<std::size_t>(in.choice(4));
        for (std::size_t i = 0; i < n; ++i) unknowns[i] = reference(in, hnav::fmu::Type::real);
        for (std::size_t i = 0; i < k; ++i) {
            knowns[i] = reference(in, hnav::fmu::Type::real);
            seed[i] = in.number();
        }
    }
};

// Whether a value is in the range of its row.
inline void look_at(unsigned reference, double value) {
    const hnav::fmu::Variable& v = description().table[static_cast<int>(reference) - 1];
    if (v.type == hnav::fmu::Type::enumeration && v.causality != hnav::fmu::Causality::input)
        HOLDS(value >= v.min && value <= v.max);
    HOLDS(!std::isnan(value) || v.causality == hnav::fmu::Causality::input || v.type == hnav::fmu::Type::real);
}

// Times of an instance, to make valid steps.
struct Clock {
    double t_s = 0;

    double step(Input& in) { return in.choice(4) == 3 ? in.number() : 0.01 * (1 + in.choice(4)); }
    double next(Input& in) { return in.choice(8) == 7 ? in.number() : t_s + step(in); } // of an external integrator
    double now(Input& in) { return in.choice(16) == 15 ? in.number() : t_s; }
};

// A serialised state with some bytes changed.
inline void damage(Input& in, std::vector<unsigned char>& bytes) {
    for (int n = in.choice(4); n > 0 && !bytes.empty(); --n) {
        const std::size_t at = (in.byte() * 256u + in.byte()) % bytes.size();
        bytes[in.flag() ? at : at % 96] ^= static_cast<unsigned char>(1 + in.choice(255)); // the first hold mode and times
    }
}

} // namespace fuzz
