// The folder of resources as a path: FMI 2 gives it as a URI.
#pragma once

#include <cstdlib>
#include <cstring>

namespace hnav::fmu {

class ResourcePath {
public:
    // file:///C:/a%20b, file:/home/a, file://localhost/home/a; any other text is taken as a path. Empty if it is too long.
    explicit ResourcePath(const char* uri) {
        const char* from = uri ? uri : "";
        if (std::strncmp(from, "file:", 5) == 0) from = path_of(from + 5);
        std::size_t length = 0;
        for (; *from && length + 1 < sizeof text_; ++length) text_[length] = decoded(&from);
        text_[*from ? 0 : length] = '\0';
    }
    operator const char*() const { return text_; }

private:
    // The part after the host, which must be this one; on Windows without the slash before the drive.
    static const char* path_of(const char* from) {
        if (std::strncmp(from, "//", 2) == 0) {
            const char* path = std::strchr(from + 2, '/');
            from = path ? path : "";
        }
        return from[0] == '/' && from[1] && from[2] == ':' ? from + 1 : from;
    }

    static char decoded(const char** from) {
        const char digits[] = {**from == '%' ? (*from)[1] : '\0', **from == '%' && (*from)[1] ? (*from)[2] : '\0', '\0'};
        char* end = nullptr;
        const long code = std::strtol(digits, &end, 16);
        const bool escaped = digits[0] && digits[1] && end == digits + 2;
        *from += escaped ? 3 : 1;
        return escaped ? static_cast<char>(code) : (*from)[-1];
    }

    char text_[1024];
};

} // namespace hnav::fmu
