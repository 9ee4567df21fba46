# macOS 11 and newer on Apple silicon.
set(CMAKE_SYSTEM_PROCESSOR arm64)
set(HNAV_ZIG_TARGET aarch64-macos.11.0)
include("${CMAKE_CURRENT_LIST_DIR}/macos.cmake")
