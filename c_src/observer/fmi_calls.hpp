// The functions of an FMU's library by name, and the calls of an instance in which FMI 2 and FMI 3 differ in types alone.
#pragma once

#include "observer/fmi_instance.hpp"

namespace hnav::observer {

// Which kinds of instance must have it.
enum class Needed { never, always, by_steps, by_exchange };

struct NamedFunction {
    // Enters the list as its last.
    NamedFunction(NamedFunction*& list, const char* name, Needed needed) : name(name), needed(needed) {
        NamedFunction** end = &list;
        while (*end) end = &(*end)->next;
        *end = this;
    }
    NamedFunction(const NamedFunction&) = delete;
    NamedFunction& operator=(const NamedFunction&) = delete;

    const char* const name;
    const Needed needed;
    NamedFunction* next = nullptr;
    void* symbol = nullptr; // null: the library does not have it
};

template <class Type>
struct FmiFunction : NamedFunction {
    using NamedFunction::NamedFunction;

    template <class... Arguments>
    auto operator()(Arguments... arguments) const {
        return reinterpret_cast<Type*>(symbol)(arguments...);
    }
};

// A member of the structs of functions, which begin with a null pointer `list`.
#define HNAV_FMI_FUNCTION(member, function, needed)                                                                              \
    FmiFunction<function##TYPE> member { list, #function, Needed::needed }

template <class Functions>
class FmiCalls : public FmiInstance {
public:
    using FmiInstance::FmiInstance;

    bool find(const SharedLibrary& library, const char** missing) override {
        const Needed kind = steps() ? Needed::by_steps : Needed::by_exchange;
        for (NamedFunction* one = f_.list; one; one = one->next) {
            one->symbol = library.symbol(one->name);
            *missing = one->name;
            if (!one->symbol && (one->needed == Needed::always || one->needed == kind)) return false;
        }
        return true;
    }

    void free() override {
        if (instance_ && !dead) f_.free(instance_);
        instance_ = nullptr;
    }
    Answer exit_initialization() override { return ask(f_.exit_initialization); }
    Answer enter_event_mode() override { return ask(f_.enter_event_mode); }
    Answer enter_continuous_time_mode() override { return ask(f_.enter_continuous_time_mode); }
    Answer set_time(double t_s) override { return ask(f_.set_time, t_s); }
    Answer set_states(const double* x, int count) override { return ask(f_.set_states, x, count); }
    Answer get_states(double* x, int count) override { return ask(f_.get_states, x, count); }
    Answer get_nominals(double* x, int count) override { return ask(f_.get_nominals, x, count); }
    Answer get_derivatives(double* dx, int count) override { return ask(f_.get_derivatives, dx, count); }
    Answer get_indicators(double* z, int count) override { return ask(f_.get_indicators, z, count); }

    Answer get_state(void** state) override { return ask(f_.get_state, state); }
    Answer set_state(void* state) override { return ask(f_.set_state, state); }
    void free_state(void** state) override {
        if (*state && f_.free_state.symbol && instance_ && !dead) f_.free_state(instance_, state);
        *state = nullptr;
    }
    Answer state_bytes(void* state, std::size_t* bytes) override { return ask(f_.state_bytes, state, bytes); }
    Answer serialize(void* state, void* bytes, std::size_t count) override {
        return ask(f_.serialize, state, static_cast<Byte*>(bytes), count);
    }
    Answer deserialize(const void* bytes, std::size_t count, void** state) override {
        return ask(f_.deserialize, static_cast<const Byte*>(bytes), count, state);
    }

protected:
    using Byte = typename Functions::Byte;

    // Broken without the function.
    template <class Function, class... Arguments>
    Answer ask(const Function& function, Arguments... arguments) {
        return function.symbol ? answer(function(instance_, arguments...)) : Answer::broken;
    }

    Functions f_;
    void* instance_ = nullptr;
};

} // namespace hnav::observer
