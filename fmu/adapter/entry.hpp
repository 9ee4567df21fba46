// Shared by the entry points of both FMI versions: the instance behind the importer's pointer, and the returned status.
#pragma once

#include "adapter/float_traps.hpp"
#include "adapter/instance.hpp"

namespace hnav::fmu {

inline Instance* of(void* instance) { return static_cast<Instance*>(instance); }

// FmiStatus: the enumeration of the FMI version, with its values for success, warning and failure.
template <class FmiStatus, FmiStatus ok, FmiStatus warning, FmiStatus error>
struct Entry {
    static FmiStatus to_fmi(Status status) { return status == Status::ok ? ok : status == Status::warning ? warning : error; }

    // Calls a method of the instance. Without an instance nothing can be logged.
    template <class Method, class... Arguments>
    static FmiStatus call(void* instance, Method method, Arguments... arguments) {
        const WithoutFloatTraps quiet;
        return instance ? to_fmi((of(instance)->*method)(arguments...)) : error;
    }

    static FmiStatus fail(void* instance, const char* text) { return instance ? to_fmi(of(instance)->fail("%s", text)) : error; }

    // Functions of capabilities that these FMUs do not have.
    static FmiStatus unsupported(void* instance, const char* name) {
        return instance ? to_fmi(of(instance)->fail("%s is not supported by this FMU", name)) : error;
    }

    template <class T>
    static FmiStatus get(void* instance, Type type, const unsigned* references, std::size_t n, T* values, std::size_t n_values) {
        if (call(instance, &Instance::check_array, references, n, values, n_values) != ok) return error;
        const WithoutFloatTraps quiet;
        return to_fmi(of(instance)->get(type, references, n, values));
    }

    template <class T>
    static FmiStatus set(void* instance, Type type, const unsigned* references, std::size_t n, const T* values,
                         std::size_t n_values) {
        if (call(instance, &Instance::check_array, references, n, values, n_values) != ok) return error;
        const WithoutFloatTraps quiet;
        return to_fmi(of(instance)->set(type, references, n, values));
    }
};

} // namespace hnav::fmu
