// What FMI calls this machine: where an FMU has the binary for it.
#pragma once

#include <cstdio>
#include <cstring>

namespace hnav::observer {

#if defined(_WIN32)
constexpr const char *system_name = "windows", *system_of_fmi_2 = "win64", *library_ending = "dll";
#elif defined(__APPLE__)
constexpr const char *system_name = "darwin", *system_of_fmi_2 = "darwin64", *library_ending = "dylib";
#else
constexpr const char *system_name = "linux", *system_of_fmi_2 = "linux64", *library_ending = "so";
#endif
#if defined(__aarch64__) || defined(_M_ARM64)
constexpr const char* machine_name = "aarch64";
#else
constexpr const char* machine_name = "x86_64";
#endif

// binaries/*/NAME.* for this machine; a path without stars as it is. False: it is too long.
inline bool binary_here(const char* pattern, int fmi, char* path, std::size_t size) {
    const char *folder = std::strchr(pattern, '*'), *ending = folder ? std::strchr(folder + 1, '*') : nullptr;
    int length = 0;
    if (!ending) length = std::snprintf(path, size, "%s", pattern);
    else {
        char platform[32];
        if (fmi == 2 && std::strcmp(machine_name, "x86_64") == 0) std::snprintf(platform, sizeof platform, "%s", system_of_fmi_2);
        else std::snprintf(platform, sizeof platform, "%s-%s", machine_name, system_name);
        length = std::snprintf(path, size, "%.*s%s%.*s%s", static_cast<int>(folder - pattern), pattern, platform,
                               static_cast<int>(ending - folder - 1), folder + 1, library_ending);
    }
    return length >= 0 && static_cast<std::size_t>(length) < size;
}

} // namespace hnav::observer
