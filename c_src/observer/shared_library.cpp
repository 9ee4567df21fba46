#include "observer/shared_library.hpp"

#include <cstdio>
#include <cstdlib>
#include <cstring>

#ifdef _WIN32
#define WIN32_LEAN_AND_MEAN
#include <windows.h>
#else
#include <dlfcn.h>
#include <unistd.h>
#endif

namespace hnav::observer {

#ifdef _WIN32

bool SharedLibrary::open(const char* path, char* why, std::size_t size) {
    wchar_t wide[1024];
    if (MultiByteToWideChar(CP_UTF8, 0, path, -1, wide, 1024) > 0)
        // Libraries in the same folder are found too.
        handle_ = static_cast<void*>(LoadLibraryExW(wide, nullptr, LOAD_WITH_ALTERED_SEARCH_PATH));
    if (!handle_) std::snprintf(why, size, "Windows says %lu", static_cast<unsigned long>(GetLastError()));
    return handle_ != nullptr;
}

void SharedLibrary::close() {
    if (handle_ && !stays_) FreeLibrary(static_cast<HMODULE>(handle_));
    handle_ = nullptr;
    remove_copy();
}

bool SharedLibrary::is_loaded(const char* path) {
    wchar_t wide[1024];
    return MultiByteToWideChar(CP_UTF8, 0, path, -1, wide, 1024) > 0 && GetModuleHandleW(wide);
}

bool SharedLibrary::copy_file(const char* from, const char* to) {
    wchar_t wide_from[1024], wide_to[1024];
    return MultiByteToWideChar(CP_UTF8, 0, from, -1, wide_from, 1024) > 0 &&
           MultiByteToWideChar(CP_UTF8, 0, to, -1, wide_to, 1024) > 0 && CopyFileW(wide_from, wide_to, TRUE);
}

void SharedLibrary::remove_copy() {
    wchar_t wide[1024];
    if (*copy_ && MultiByteToWideChar(CP_UTF8, 0, copy_, -1, wide, 1024) > 0) DeleteFileW(wide);
    *copy_ = '\0';
}

namespace {

unsigned long process_number() { return static_cast<unsigned long>(GetCurrentProcessId()); }
const char* temporary_folder() { return std::getenv("TEMP"); }

} // namespace

void* SharedLibrary::symbol(const char* name) const {
    return reinterpret_cast<void*>(GetProcAddress(static_cast<HMODULE>(handle_), name));
}

#else

namespace {

// In a process that has loaded an FMU with global symbols, possibly the FMU around this code, the functions of that FMU would be
// found before the plant's own. The plant's own must come first.
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
    remove_copy();
}

bool SharedLibrary::is_loaded(const char* path) {
    void* loaded = dlopen(path, RTLD_NOW | RTLD_NOLOAD);
    if (loaded) dlclose(loaded);
    return loaded != nullptr;
}

void* SharedLibrary::symbol(const char* name) const { return dlsym(handle_, name); }

bool SharedLibrary::copy_file(const char* from, const char* to) {
    std::FILE* in = std::fopen(from, "rb");
    std::FILE* out = in ? std::fopen(to, "wbx") : nullptr;
    bool whole = out != nullptr;
    char bytes[16384];
    for (std::size_t count = 0; whole && (count = std::fread(bytes, 1, sizeof bytes, in)) > 0;)
        whole = std::fwrite(bytes, 1, count, out) == count;
    whole = whole && !std::ferror(in);
    if (out) whole = std::fclose(out) == 0 && whole;
    if (in) std::fclose(in);
    return whole;
}

// A loaded library remains usable without its file.
void SharedLibrary::remove_copy() {
    if (*copy_) std::remove(copy_);
    *copy_ = '\0';
}

namespace {

unsigned long process_number() { return static_cast<unsigned long>(getpid()); }
const char* temporary_folder() {
    const char* folder = std::getenv("TMPDIR");
    return folder && *folder ? folder : "/tmp";
}

} // namespace

#endif

// Beside the file, where its libraries may be, or else in the folder of temporary files. If neither is writable, it is shared.
bool SharedLibrary::open_alone(const char* path, char* why, std::size_t size) {
    if (!is_loaded(path)) return open(path, why, size);
    const char* name = std::strrchr(path, '/');
    const int length = name ? static_cast<int>(name - path) : 0;
    if (name && open_copy(path, path, length, name + 1)) return true;
    const char* folder = temporary_folder();
    if (name && folder && open_copy(path, folder, static_cast<int>(std::strlen(folder)), name + 1)) return true;
    return open(path, why, size);
}

bool SharedLibrary::open_copy(const char* path, const char* folder, int length, const char* name) {
    char why[64];
    const int written = std::snprintf(copy_, sizeof copy_, "%.*s/hnav_%lu_%p_%s", length, folder, process_number(),
                                      static_cast<void*>(this), name);
    const bool fits = written > 0 && written < static_cast<int>(sizeof copy_);
    const bool loaded = fits && copy_file(path, copy_) && open(copy_, why, sizeof why);
#ifndef _WIN32
    remove_copy();
#endif
    if (!loaded) remove_copy();
    return loaded;
}

} // namespace hnav::observer
