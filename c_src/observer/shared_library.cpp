#include "observer/shared_library.hpp"

#include <cstdio>

#ifdef _WIN32
#define WIN32_LEAN_AND_MEAN
#include <windows.h>
#else
#include <dlfcn.h>
#endif

namespace hnav::observer {

#ifdef _WIN32

bool SharedLibrary::open(const char* path, char* why, std::size_t size) {
    wchar_t wide[1024];
    if (MultiByteToWideChar(CP_UTF8, 0, path, -1, wide, 1024) > 0)
        // The libraries beside it are found too.
        handle_ = static_cast<void*>(LoadLibraryExW(wide, nullptr, LOAD_WITH_ALTERED_SEARCH_PATH));
    if (!handle_) std::snprintf(why, size, "Windows says %lu", static_cast<unsigned long>(GetLastError()));
    return handle_ != nullptr;
}

void SharedLibrary::close() {
    if (handle_ && !stays_) FreeLibrary(static_cast<HMODULE>(handle_));
    handle_ = nullptr;
}

void* SharedLibrary::symbol(const char* name) const {
    return reinterpret_cast<void*>(GetProcAddress(static_cast<HMODULE>(handle_), name));
}

#else

namespace {

// Whoever has loaded an FMU with its names open to all, as the one that may be around us, has its functions found before those of
// the plant, when the plant calls its own: then these have to come first.
int flags() {
#ifdef RTLD_DEEPBIND
    if (dlsym(RTLD_DEFAULT, "fmi2Instantiate") || dlsym(RTLD_DEFAULT, "fmi3InstantiateModelExchange"))
        return RTLD_NOW | RTLD_LOCAL | RTLD_DEEPBIND;
#endif
    return RTLD_NOW | RTLD_LOCAL;
}

} // namespace

bool SharedLibrary::open(const char* path, char* why, std::size_t size) {
    handle_ = dlopen(path, flags());
    if (handle_) return true;
    const char* said = dlerror();
    std::snprintf(why, size, "%s", said ? said : "no reason is known");
    return false;
}

void SharedLibrary::close() {
    if (handle_ && !stays_) dlclose(handle_);
    handle_ = nullptr;
}

void* SharedLibrary::symbol(const char* name) const { return dlsym(handle_, name); }

#endif

} // namespace hnav::observer
