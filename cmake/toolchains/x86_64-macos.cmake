# macOS 11 and newer on Intel processors.
set(CMAKE_SYSTEM_PROCESSOR x86_64)
set(HNAV_ZIG_TARGET x86_64-macos.11.0)
include("${CMAKE_CURRENT_LIST_DIR}/macos.cmake")
