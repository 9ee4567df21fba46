# Linux on 64-bit ARM, running with glibc 2.17, the first that knows it, and everything newer.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(HNAV_ZIG_TARGET aarch64-linux-gnu.2.17)
set(HNAV_GLIBC 2.17)
include("${CMAKE_CURRENT_LIST_DIR}/zig.cmake")
