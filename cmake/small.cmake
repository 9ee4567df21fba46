# The small build: no SUNDIALS, nothing from the heap, no printf; see docs/embedded.md.
if(NOT HNAV_SMALL_SCALAR MATCHES "^(float|double)$")
  message(FATAL_ERROR "HNAV_SMALL_SCALAR is '${HNAV_SMALL_SCALAR}': it is float or double")
endif()

add_library(hnav_small STATIC ${small_sources})
add_library(hnav::hnav_small ALIAS hnav_small)
target_include_directories(hnav_small PUBLIC ${CMAKE_CURRENT_SOURCE_DIR}/include PRIVATE ${CMAKE_CURRENT_SOURCE_DIR})
target_link_libraries(hnav_small PRIVATE hnav_flags Eigen3::Eigen)
target_compile_definitions(hnav_small PRIVATE HNAV_SMALL HNAV_SCALAR=${HNAV_SMALL_SCALAR})
# A program takes of it what it calls. -Os alone lets Eigen write out the copies of each matrix size and call a function for
# every element: with loops, and its small functions in their places, code is half as large.
target_compile_options(hnav_small PRIVATE -Os -ffunction-sections -fdata-sections)
# GCC sees matrices that are filled in a loop as read before written, and pairs of numbers where there is one.
target_compile_options(hnav_small PRIVATE "$<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized;-Wno-array-bounds>")
# Sanitizers watch each of those small functions: in their places a file takes a compiler twenty minutes, without one.
if(NOT HNAV_SANITIZE)
  target_compile_definitions(hnav_small PRIVATE EIGEN_UNROLLING_LIMIT=0
                             "EIGEN_STRONG_INLINE=inline __attribute__((always_inline))")
endif()
if(CMAKE_SYSTEM_NAME STREQUAL Generic)
  set_target_properties(hnav_small PROPERTIES POSITION_INDEPENDENT_CODE OFF)
endif()
