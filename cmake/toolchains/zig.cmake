# clang, lld and the C libraries of every target in one package, from zig (the Python package ziglang has it): the part
# that all targets share. Each target's file sets CMAKE_SYSTEM_NAME, CMAKE_SYSTEM_PROCESSOR and HNAV_ZIG_TARGET first.
#   HNAV_ZIG   the program zig; empty: the environment variable of this name, then the one in PATH

# The checks that SUNDIALS makes in projects of their own get no variables from us, but the environment.
if(NOT HNAV_ZIG)
  set(HNAV_ZIG "$ENV{HNAV_ZIG}")
endif()
if(NOT HNAV_ZIG)
  find_program(HNAV_ZIG zig)
endif()
if(NOT HNAV_ZIG)
  message(FATAL_ERROR "HNAV_ZIG: no program zig found. `pip install ziglang` brings one; give its path as -DHNAV_ZIG=...")
endif()
set(ENV{HNAV_ZIG} "${HNAV_ZIG}")

# CMake wants a compiler to be one program, so each tool gets a file of its own.
set(hnav_zig_tools "${CMAKE_BINARY_DIR}/zig-${HNAV_ZIG_TARGET}")
get_filename_component(hnav_zig_top "${CMAKE_CURRENT_LIST_DIR}/../.." ABSOLUTE)
foreach(tool cc c++)
  # Without -g0 zig adds debug information, which is most of a static library. The same bytes come from every checkout: what a
  # compiler writes of the place of a file is relative to the top.
  set(hnav_zig_command "${tool} -target ${HNAV_ZIG_TARGET} -g0 '-ffile-prefix-map=${hnav_zig_top}=.'")
  file(CONFIGURE OUTPUT "${hnav_zig_tools}/${tool}" CONTENT "#!/bin/sh\nexec \"@HNAV_ZIG@\" @hnav_zig_command@ \"$@\"\n" @ONLY)
endforeach()
foreach(tool ar ranlib rc)
  file(CONFIGURE OUTPUT "${hnav_zig_tools}/${tool}" CONTENT "#!/bin/sh\nexec \"@HNAV_ZIG@\" @tool@ \"$@\"\n" @ONLY)
endforeach()
file(GLOB hnav_zig_files "${hnav_zig_tools}/*")
file(CHMOD ${hnav_zig_files} PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)

set(CMAKE_C_COMPILER "${hnav_zig_tools}/cc")
set(CMAKE_CXX_COMPILER "${hnav_zig_tools}/c++")
set(CMAKE_AR "${hnav_zig_tools}/ar" CACHE FILEPATH "" FORCE)
set(CMAKE_RANLIB "${hnav_zig_tools}/ranlib" CACHE FILEPATH "" FORCE)
set(CMAKE_RC_COMPILER "${hnav_zig_tools}/rc")

# Headers without code (Eigen) may come from the build machine; libraries and programs of the target may not.
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
