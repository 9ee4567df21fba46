# SUNDIALS, built from source at -O3 whatever our own build type is: distributions compile it without optimisation,
# which makes a step five times slower. Gives one target, hnav_sundials: ARKODE, CVODE and the core, static.
#
# The source comes from the first of
#   HNAV_SUNDIALS_SOURCE                    a folder with an unpacked release, 6.4 to 7.x
#   FETCHCONTENT_SOURCE_DIR_SUNDIALS        the same, by the name that CMake users expect
#   the source package of Debian or Ubuntu  by apt-get, with a list and a state folder of our own
#   HNAV_SUNDIALS_URL                       the upstream release, by its hash
# HNAV_PINNED=ON, of ./run release: no archive is taken whose SHA-256 does not stand in this file.
# HNAV_SYSTEM_SUNDIALS=ON takes an installed one instead (find_package). It calls malloc itself, and not all of its own calls
# look at the answer: out of memory, a create call with one of its solvers may crash. The SUNDIALS that is built here takes
# its memory from hnav (c_src/hybrid/sundials_memory.hpp).

option(HNAV_SYSTEM_SUNDIALS "Use an installed SUNDIALS instead of building one" OFF)
set(HNAV_SUNDIALS_SOURCE "" CACHE PATH "Unpacked SUNDIALS release, 6.4 to 7.x; empty: fetch it")
set(HNAV_SUNDIALS_URL
    "https://github.com/LLNL/sundials/releases/download/v6.7.0/sundials-6.7.0.tar.gz"
    CACHE STRING "Where to download SUNDIALS from when no source package is to be had")
set(HNAV_SUNDIALS_SHA256 "5f113a1564a9d2d98ff95249f4871a4c815a05dbb9b8866a82b13ab158c37adb"
    CACHE STRING "SHA-256 of HNAV_SUNDIALS_URL")
option(HNAV_PINNED "Take no archive of SUNDIALS whose SHA-256 is not pinned" OFF)
# sundials_6.4.1+dfsg1.orig.tar.xz of Debian 12
set(hnav_sundials_pins c61157f1d4be06c704bea40cb131eb63ba2dada161989071604d0a0959cdf04a ${HNAV_SUNDIALS_SHA256})

add_library(hnav_sundials INTERFACE)

if(HNAV_SYSTEM_SUNDIALS)
  find_package(SUNDIALS 6.4 REQUIRED COMPONENTS arkode cvode)
  target_link_libraries(hnav_sundials INTERFACE SUNDIALS::arkode SUNDIALS::cvode)
  return()
endif()

set(hnav_sundials_work "${CMAKE_BINARY_DIR}/sundials")
set(hnav_sundials_prefix "${hnav_sundials_work}/install")

# Fails with the tail of the log, which is what a reader needs.
function(hnav_run log)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_FILE "${log}" ERROR_FILE "${log}")
  if(NOT result EQUAL 0)
    file(READ "${log}" text)
    string(LENGTH "${text}" length)
    if(length GREATER 3000)
      math(EXPR start "${length} - 3000")
      string(SUBSTRING "${text}" ${start} -1 text)
    endif()
    message(FATAL_ERROR "SUNDIALS: ${ARGN}\nfailed (${log}):\n${text}")
  endif()
endfunction()

# Leaves the folder with the sources in ${result}, or an empty string; origin: where the archive is from, for the list of parts.
function(hnav_sundials_from_archive archive origin result)
  set(${result} "" PARENT_SCOPE)
  file(SHA256 "${archive}" hash)
  if(HNAV_PINNED AND NOT hash IN_LIST hnav_sundials_pins)
    message(STATUS "SUNDIALS: ${origin} has SHA-256 ${hash}, which is not pinned in cmake/sundials.cmake, and is not taken")
    return()
  endif()
  file(REMOVE_RECURSE "${hnav_sundials_work}/source")
  file(MAKE_DIRECTORY "${hnav_sundials_work}/source")
  execute_process(COMMAND ${CMAKE_COMMAND} -E tar xf "${archive}"
                  WORKING_DIRECTORY "${hnav_sundials_work}/source" RESULT_VARIABLE failed)
  file(GLOB folders "${hnav_sundials_work}/source/sundials-*")
  if(NOT failed AND folders)
    list(GET folders 0 folder)
    set(${result} "${folder}" PARENT_SCOPE)
    file(WRITE "${hnav_sundials_work}/origin.txt" "${origin}\n${hash}\n")
  endif()
endfunction()

function(hnav_sundials_from_apt result)
  set(${result} "" PARENT_SCOPE)
  find_program(HNAV_APT_GET apt-get)
  mark_as_advanced(HNAV_APT_GET)
  if(NOT HNAV_APT_GET)
    return()
  endif()
  message(STATUS "SUNDIALS: asking apt for the source package")
  execute_process(COMMAND sh "${CMAKE_CURRENT_LIST_DIR}/apt_source.sh" sundials "${hnav_sundials_work}/apt"
                  OUTPUT_VARIABLE archive OUTPUT_STRIP_TRAILING_WHITESPACE
                  ERROR_FILE "${hnav_sundials_work}/apt.log" RESULT_VARIABLE failed)
  if(NOT failed AND EXISTS "${archive}")
    get_filename_component(name "${archive}" NAME)
    hnav_sundials_from_archive("${archive}" "${name}" folder)
    set(${result} "${folder}" PARENT_SCOPE)
  endif()
endfunction()

function(hnav_sundials_from_url result)
  message(STATUS "SUNDIALS: downloading ${HNAV_SUNDIALS_URL}")
  set(archive "${hnav_sundials_work}/sundials.tar.gz")
  file(DOWNLOAD "${HNAV_SUNDIALS_URL}" "${archive}" STATUS status INACTIVITY_TIMEOUT 15 TIMEOUT 300)
  list(GET status 0 code)
  set(folder "")
  if(code EQUAL 0)
    file(SHA256 "${archive}" hash)
    if(NOT hash STREQUAL HNAV_SUNDIALS_SHA256)
      message(FATAL_ERROR "SUNDIALS: ${HNAV_SUNDIALS_URL} has SHA-256 ${hash}, expected ${HNAV_SUNDIALS_SHA256}")
    endif()
    hnav_sundials_from_archive("${archive}" "${HNAV_SUNDIALS_URL}" folder)
  endif()
  set(${result} "${folder}" PARENT_SCOPE)
endfunction()

# What the finished build depends on; when it changes, SUNDIALS is built again.
# Without contraction here too: on ARM it is the compiler's default, and the bits would differ from those of x86-64.
set(hnav_sundials_flags "-fvisibility=hidden -ffunction-sections -fdata-sections -ffp-contract=off")
set(hnav_sundials_memory "${PROJECT_SOURCE_DIR}/c_src/hybrid/sundials_memory.h")
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${hnav_sundials_memory}")
file(SHA256 "${hnav_sundials_memory}" hnav_sundials_memory_hash)
set(hnav_sundials_stamp
    "${HNAV_SUNDIALS_SOURCE}${FETCHCONTENT_SOURCE_DIR_SUNDIALS}|${CMAKE_C_COMPILER}|${HNAV_SANITIZE}|${hnav_sundials_flags}")
string(APPEND hnav_sundials_stamp "|${hnav_sundials_memory_hash}")
set(hnav_sundials_stamp_file "${hnav_sundials_prefix}/stamp.txt")
set(hnav_sundials_built "")
if(EXISTS "${hnav_sundials_stamp_file}")
  file(READ "${hnav_sundials_stamp_file}" hnav_sundials_built)
endif()

if(NOT hnav_sundials_built STREQUAL hnav_sundials_stamp)
  file(MAKE_DIRECTORY "${hnav_sundials_work}")
  set(hnav_sundials_source "${HNAV_SUNDIALS_SOURCE}")
  if(NOT hnav_sundials_source)
    set(hnav_sundials_source "${FETCHCONTENT_SOURCE_DIR_SUNDIALS}")
  endif()
  if(NOT hnav_sundials_source)
    hnav_sundials_from_apt(hnav_sundials_source)
  endif()
  if(NOT hnav_sundials_source)
    hnav_sundials_from_url(hnav_sundials_source)
  endif()
  if(NOT EXISTS "${hnav_sundials_source}/CMakeLists.txt")
    message(FATAL_ERROR "SUNDIALS: no source found. Unpack a release (6.4 to 7.x) and give its folder as "
                        "-DHNAV_SUNDIALS_SOURCE=..., or install one and give -DHNAV_SYSTEM_SUNDIALS=ON.")
  endif()
  message(STATUS "SUNDIALS: building ${hnav_sundials_source}")
  # Single quotes: version 7 writes the flags into a CMakeLists.txt between double ones.
  set(flags "${hnav_sundials_flags} -ffile-prefix-map=${hnav_sundials_source}=sundials -include '${hnav_sundials_memory}'")
  # For another machine than this one the toolchain names the compiler.
  set(compiler "-DCMAKE_C_COMPILER=${CMAKE_C_COMPILER}")
  if(CMAKE_TOOLCHAIN_FILE)
    set(compiler "-DCMAKE_TOOLCHAIN_FILE=${CMAKE_TOOLCHAIN_FILE}")
  endif()
  set(options "")
  foreach(off BUILD_CVODES BUILD_IDA BUILD_IDAS BUILD_KINSOL BUILD_SHARED_LIBS BUILD_TESTING BUILD_FORTRAN_MODULE_INTERFACE
              EXAMPLES_ENABLE_C EXAMPLES_ENABLE_CXX EXAMPLES_INSTALL ENABLE_MPI ENABLE_OPENMP ENABLE_PTHREAD
              SUNDIALS_BUILD_WITH_PROFILING)
    list(APPEND options -D${off}=OFF)
  endforeach()
  hnav_run("${hnav_sundials_work}/configure.log" ${CMAKE_COMMAND}
           -S "${hnav_sundials_source}" -B "${hnav_sundials_work}/build" -G "${CMAKE_GENERATOR}"
           -DCMAKE_BUILD_TYPE=Release ${compiler} "-DCMAKE_C_FLAGS=${flags}"
           -DCMAKE_C_FLAGS_RELEASE=-O3 -DCMAKE_POSITION_INDEPENDENT_CODE=ON -DCMAKE_INSTALL_LIBDIR=lib
           "-DCMAKE_INSTALL_PREFIX=${hnav_sundials_prefix}" -DBUILD_ARKODE=ON -DBUILD_CVODE=ON
           -DSUNDIALS_LOGGING_LEVEL=0 ${options})
  hnav_run("${hnav_sundials_work}/build.log" ${CMAKE_COMMAND} --build "${hnav_sundials_work}/build" --target install --parallel)
  # The licence travels with every binary that holds the code.
  file(COPY "${hnav_sundials_source}/LICENSE" DESTINATION "${hnav_sundials_prefix}")
  file(WRITE "${hnav_sundials_stamp_file}" "${hnav_sundials_stamp}")
endif()

target_include_directories(hnav_sundials SYSTEM INTERFACE "${hnav_sundials_prefix}/include")
# Version 7 calls the core library core, before it was generic.
foreach(name arkode cvode core generic)
  set(library "${hnav_sundials_prefix}/lib/libsundials_${name}.a")
  if(EXISTS "${library}")
    target_link_libraries(hnav_sundials INTERFACE "${library}")
  endif()
endforeach()
target_link_libraries(hnav_sundials INTERFACE m)
set(HNAV_SUNDIALS_LICENSE "${hnav_sundials_prefix}/LICENSE")
