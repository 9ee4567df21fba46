// A dynamic library loaded at run time.
#pragma once

#include <cstddef>

namespace hnav::observer {

class SharedLibrary {
public:
    SharedLibrary() = default;
    SharedLibrary(const SharedLibrary&) = delete;
    SharedLibrary& operator=(const SharedLibrary&) = delete;
    ~SharedLibrary() { close(); }

    // path: full, UTF-8. Its symbols are local: a plant and its loader may export the same ones. False: why has the reason.
    bool open(const char* path, char* why, std::size_t size);
    // The same from a copy of the file, so that static variables are not shared with other users of the file.
    bool open_alone(const char* path, char* why, std::size_t size);
    void close();
    // Until the process ends.
    void stay() { stays_ = true; }

    // A function; null: there is none.
    void* symbol(const char* name) const;

private:
    static bool is_loaded(const char* path);
    static bool copy_file(const char* from, const char* to);
    bool open_copy(const char* path, const char* folder, int length, const char* name);
    void remove_copy();

    void* handle_ = nullptr;
    bool stays_ = false;
    char copy_[1024] = ""; // that is to be removed when it is closed
};

} // namespace hnav::observer
