# Linux on x86-64, running with glibc 2.17 of 2012 and everything newer.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR x86_64)
set(HNAV_ZIG_TARGET x86_64-linux-gnu.2.17)
set(HNAV_GLIBC 2.17)
include("${CMAKE_CURRENT_LIST_DIR}/zig.cmake")
