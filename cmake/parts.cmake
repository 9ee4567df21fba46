# BUILD/parts.json: where the sources of others lie that the build uses; release/sbom.py lists what comes of them.
get_target_property(hnav_eigen Eigen3::Eigen INTERFACE_INCLUDE_DIRECTORIES)
list(GET hnav_eigen 0 hnav_eigen)
set(hnav_sundials_used "${HNAV_SUNDIALS_SOURCE}")
if(NOT hnav_sundials_used)
  set(hnav_sundials_used "${FETCHCONTENT_SOURCE_DIR_SUNDIALS}")
endif()
if(NOT hnav_sundials_used)
  file(GLOB hnav_sundials_used "${CMAKE_BINARY_DIR}/sundials/source/sundials-*")
endif()
file(CONFIGURE OUTPUT "${CMAKE_BINARY_DIR}/parts.json" @ONLY CONTENT [[{
  "Eigen": {"folder": "@hnav_eigen@", "version": "@Eigen3_VERSION@"},
  "SUNDIALS": {"folder": "@hnav_sundials_used@", "built": "@CMAKE_BINARY_DIR@/sundials"},
  "FMI": {"folder": "@HNAV_FMI_HEADERS@"},
  "zig": {"program": "@HNAV_ZIG@"}
}
]])
