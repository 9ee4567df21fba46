# What both processors of macOS share. Apple's tools are not needed: zig brings the headers of the system's C library and what
# its linker has to know of it.
set(CMAKE_SYSTEM_NAME Darwin)
include("${CMAKE_CURRENT_LIST_DIR}/zig.cmake")
# The target says all that CMake would ask Xcode for.
set(CMAKE_OSX_SYSROOT "" CACHE STRING "" FORCE)
set(CMAKE_OSX_DEPLOYMENT_TARGET "" CACHE STRING "" FORCE)
set(CMAKE_INSTALL_NAME_TOOL /bin/false CACHE FILEPATH "" FORCE) # nothing is installed from here
