// A library of code that is loaded at run time.
#pragma once

#include <cstddef>

namespace hnav::observer {

class SharedLibrary {
public:
    SharedLibrary() = default;
    SharedLibrary(const SharedLibrary&) = delete;
    SharedLibrary& operator=(const SharedLibrary&) = delete;
    ~SharedLibrary() { close(); }

    // path: full, UTF-8. Its names stay its own: a plant and who loads it may export the same ones. False: why says it.
    bool open(const char* path, char* why, std::size_t size);
    void close();
    // Until the process ends.
    void stay() { stays_ = true; }

    // Null: there is no such function.
    template <class Function>
    Function* function(const char* name) const {
        return reinterpret_cast<Function*>(symbol(name));
    }

private:
    void* symbol(const char* name) const;

    void* handle_ = nullptr;
    bool stays_ = false;
};

} // namespace hnav::observer
