# hnav_add_fmu: from a table and a model to archives that importers take. The FMI headers lie in HNAV_FMI_HEADERS.
include(${PROJECT_SOURCE_DIR}/cmake/aircraft_data.cmake)
include(${PROJECT_SOURCE_DIR}/fmu/adapter/sources.cmake)
set(hnav_fmu_folder ${PROJECT_SOURCE_DIR}/fmu)
if(NOT EXISTS "${HNAV_FMI_HEADERS}/fmi3Functions.h" OR NOT EXISTS "${HNAV_FMI_HEADERS}/fmi2Functions.h")
  message(FATAL_ERROR "HNAV_FMI_HEADERS = \"${HNAV_FMI_HEADERS}\" does not hold fmi2Functions.h and fmi3Functions.h; "
                      "the Python package fmpy has them in its folder c-code.")
endif()

# All archives.
add_custom_target(fmus)
# The binaries alone, fmiN/NAME.so or .dll. Built for another machine there is no more to make here: the rest of an
# archive is written by a program that has to run, and comes from a build for this machine (release/fmu_archives.py).
add_custom_target(fmu_binaries)
# CMAKE_CROSSCOMPILING is true with every toolchain file, also with one for this kind of machine.
set(hnav_runs_here OFF)
if(CMAKE_SYSTEM_NAME STREQUAL CMAKE_HOST_SYSTEM_NAME AND CMAKE_SYSTEM_PROCESSOR STREQUAL CMAKE_HOST_SYSTEM_PROCESSOR)
  set(hnav_runs_here ON)
endif()

# The licence of Eigen, as its package ships it.
find_file(HNAV_EIGEN_LICENSE NAMES copyright COPYING.MPL2
          PATHS /usr/share/doc/libeigen3-dev ${EIGEN3_INCLUDE_DIR} NO_DEFAULT_PATH)
mark_as_advanced(HNAV_EIGEN_LICENSE)

# Objects of an FMU, compiled once for all that links them.
function(hnav_fmu_objects target)
  add_library(${target} OBJECT ${ARGN})
  set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ON)
  target_include_directories(${target} PRIVATE ${hnav_fmu_folder})
  target_include_directories(${target} SYSTEM PRIVATE ${HNAV_FMI_HEADERS})
  target_link_libraries(${target} PRIVATE hnav_flags hnav::hnav_static)
endfunction()

hnav_fmu_objects(fmu_adapter ${hnav_fmu_adapter})
hnav_fmu_objects(fmu_entry2 ${hnav_fmu_folder}/adapter/fmi2.cpp)
hnav_fmu_objects(fmu_entry3 ${hnav_fmu_folder}/adapter/fmi3.cpp)
hnav_fmu_objects(fmu_describe ${hnav_fmu_folder}/adapter/describe.cpp ${hnav_fmu_folder}/adapter/documentation.cpp
                 ${hnav_fmu_folder}/adapter/model_description.cpp ${hnav_fmu_folder}/adapter/reference_run.cpp)

# The binary of one version.
function(hnav_fmu_binary binary version name model)
  add_library(${binary} SHARED $<TARGET_OBJECTS:fmu_entry${version}> $<TARGET_OBJECTS:fmu_adapter> $<TARGET_OBJECTS:${model}>)
  set(folder ${CMAKE_CURRENT_BINARY_DIR}/fmi${version})
  set_target_properties(${binary} PROPERTIES PREFIX "" OUTPUT_NAME ${name} LINKER_LANGUAGE CXX
    LIBRARY_OUTPUT_DIRECTORY ${folder} RUNTIME_OUTPUT_DIRECTORY ${folder} ARCHIVE_OUTPUT_DIRECTORY ${folder})
  target_link_libraries(${binary} PRIVATE hnav_flags hnav::hnav_static hnav_sundials)
  hnav_self_contained(${binary} ${hnav_fmu_folder}/adapter/fmi${version}.map -Wl,-z,now)
  # zig's libc++ is static anyway.
  if(NOT HNAV_ZIG_TARGET)
    target_link_options(${binary} PRIVATE -static-libstdc++ -static-libgcc)
  endif()
  if(NOT HNAV_SANITIZE)
    target_link_options(${binary} PRIVATE -s)
  endif()
  add_dependencies(fmu_binaries ${binary})
endfunction()

# Where an archive and what belongs to it lie, by version: platform, icons, icons_to, terminals (a folder, of FMI 3), stage, fmu.
macro(hnav_archive_places version name folder)
  if(${version} EQUAL 2)
    set(platform linux64)
    set(icons ${folder}/icon.png)
    set(icons_to model.png)
    set(terminals "")
  else()
    set(platform ${CMAKE_SYSTEM_PROCESSOR}-linux)
    set(icons ${folder}/icon.png ${folder}/icon.svg)
    set(icons_to terminalsAndIcons/)
    set(terminals ${CMAKE_CURRENT_BINARY_DIR}/stage/fmi${version}/${name}/terminalsAndIcons)
  endif()
  set(stage ${CMAKE_CURRENT_BINARY_DIR}/stage/fmi${version}/${name})
  set(fmu ${CMAKE_BINARY_DIR}/fmus/fmi${version}/${name}.fmu)
endmacro()

# The archive of one version: what `describe` writes, the binary, icons and licences, each where the standard wants it.
# core, arrays, clocks, generated: as cmake/fmu_sources.cmake has them.
function(hnav_fmu_archive target version name folder binary describe core arrays clocks generated)
  hnav_archive_places(${version} ${name} ${folder})
  set(licences ${stage}/documentation/licenses)
  set(eigen_licence "")
  if(HNAV_EIGEN_LICENSE)
    set(eigen_licence COMMAND ${CMAKE_COMMAND} -E copy ${HNAV_EIGEN_LICENSE} ${licences}/Eigen.txt)
  endif()
  get_filename_component(fmu_folder ${folder} NAME)
  get_target_property(eigen Eigen3::Eigen INTERFACE_INCLUDE_DIRECTORIES)
  string(REPLACE ";" " " core "${core}")
  add_custom_command(OUTPUT ${fmu}
    COMMAND ${CMAKE_COMMAND} -E rm -rf ${stage}
    COMMAND ${CMAKE_COMMAND} -E make_directory ${stage}/binaries/${platform} ${licences}
            ${stage}/sources ${stage}/resources ${terminals} ${stage}/extra/org.fmi-standard.fmi-ls-ref ${CMAKE_BINARY_DIR}/fmus/fmi${version}
    COMMAND $<TARGET_FILE:${describe}> ${stage} ${version} ${folder}/doc.html ${PROJECT_VERSION}
    COMMAND ${CMAKE_COMMAND} -E copy $<TARGET_FILE:${binary}> ${stage}/binaries/${platform}/${name}.so
    COMMAND ${CMAKE_COMMAND} -E copy ${PROJECT_SOURCE_DIR}/LICENSE ${licences}/license.txt
    COMMAND ${CMAKE_COMMAND} -E copy ${HNAV_SUNDIALS_LICENSE} ${licences}/SUNDIALS.txt
    ${eigen_licence}
    COMMAND ${CMAKE_COMMAND} -DTOP=${PROJECT_SOURCE_DIR} -DEIGEN=${eigen} -DSTAGE=${stage} -DVERSION=${version} -DNAME=${name}
            -DFOLDER=${fmu_folder} -DARRAYS=${arrays} -DCLOCKS=${clocks} -DGENERATED=${generated} -DCORE=${core} -P ${PROJECT_SOURCE_DIR}/cmake/fmu_sources.cmake
    COMMAND ${CMAKE_COMMAND} -E copy ${icons} ${stage}/${icons_to}
    COMMAND ${CMAKE_COMMAND} -E chdir ${stage} ${CMAKE_COMMAND} -E tar cf ${fmu} --format=zip .
    DEPENDS ${PROJECT_SOURCE_DIR}/cmake/fmu_sources.cmake ${folder}/icon.png ${folder}/icon.svg ${folder}/doc.html ${binary} ${describe} ${PROJECT_SOURCE_DIR}/LICENSE
    COMMENT "FMI ${version}: ${name}.fmu" VERBATIM)
  add_custom_target(${target} DEPENDS ${fmu})
  add_dependencies(fmus ${target})
endfunction()

# hnav_add_fmu(NAME Hrekf FOLDER hrekf EXAMPLE attitude_filter/example_input.cpp CORE c_api/hrekf.cpp ...):
# build/fmus/fmi2/NAME.fmu and build/fmus/fmi3/NAME.fmu from FOLDER/model.cpp (the table and the model), EXAMPLE (writes the
# example input), FOLDER/doc.html, FOLDER/icon.svg and icon.png. CORE: what it needs of c_src, for the sources in the archives.
# AIRCRAFT f4c_lateral: the model is compiled for models/aircraft/f4c_lateral.json, which it includes as aircraft/data.hpp.
# ARRAYS: vectors are one variable each; CLOCKS: samples come or go by triggered clocks; FMI 2 knows neither. The targets are fmu2_name and fmu3_name, in lower case.
function(hnav_add_fmu)
  cmake_parse_arguments(FMU "ARRAYS;CLOCKS" "NAME;FOLDER;EXAMPLE;AIRCRAFT" "CORE" ${ARGN})
  string(TOLOWER ${FMU_NAME} id)
  set(folder ${hnav_fmu_folder}/${FMU_FOLDER})
  set(versions 2 3)
  set(arrays 0)
  set(clocks 0)
  if(FMU_ARRAYS)
    set(versions 3)
    set(arrays 1)
  endif()
  if(FMU_CLOCKS)
    set(versions 3)
    set(clocks 1)
  endif()
  hnav_fmu_objects(fmu_model_${id} ${folder}/model.cpp)
  hnav_fmu_objects(fmu_example_${id} ${hnav_fmu_folder}/${FMU_EXAMPLE})
  target_compile_definitions(fmu_model_${id} PRIVATE HNAV_FMU_NAME="${FMU_NAME}" HNAV_FMU_ARRAYS=${arrays} HNAV_FMU_CLOCKS=${clocks})
  set(generated "")
  if(FMU_AIRCRAFT)
    set(generated ${CMAKE_CURRENT_BINARY_DIR}/generated/${FMU_AIRCRAFT})
    hnav_aircraft_data(${FMU_AIRCRAFT} ${generated})
    target_include_directories(fmu_model_${id} PRIVATE ${generated})
    target_include_directories(fmu_example_${id} PRIVATE ${generated})
  endif()

  add_executable(describe_${id} $<TARGET_OBJECTS:fmu_describe> $<TARGET_OBJECTS:fmu_adapter>
                 $<TARGET_OBJECTS:fmu_model_${id}> $<TARGET_OBJECTS:fmu_example_${id}>)
  set_target_properties(describe_${id} PROPERTIES LINKER_LANGUAGE CXX)
  target_link_libraries(describe_${id} PRIVATE hnav_flags hnav::hnav_static hnav_sundials)
  foreach(version ${versions})
    hnav_fmu_binary(fmi${version}_${id} ${version} ${FMU_NAME} fmu_model_${id})
    if(hnav_runs_here)
      hnav_fmu_archive(fmu${version}_${id} ${version} ${FMU_NAME} ${folder} fmi${version}_${id} describe_${id}
                       "${FMU_CORE}" ${arrays} ${clocks} "${generated}")
    endif()
  endforeach()
endfunction()

# hnav_add_observer(Observer Pendulum FOLDER): the FMU around any plant, here around one of ours. What differs from plant to plant is
# text, which `makers.observer` has written to FOLDER/both, FOLDER/fmi2 and FOLDER/fmi3.
function(hnav_add_observer name plant texts)
  string(TOLOWER ${name} id)
  string(TOLOWER ${plant} plant_id)
  set(folder ${hnav_fmu_folder}/${id})
  hnav_fmu_objects(fmu_model_${id} ${folder}/model.cpp ${folder}/variables.cpp)
  foreach(version 2 3)
    hnav_fmu_binary(fmi${version}_${id} ${version} ${name} fmu_model_${id})
    if(hnav_runs_here)
      hnav_observer_archive(${version} ${name} ${id} ${plant} ${plant_id} ${texts})
    endif()
  endforeach()
endfunction()

function(hnav_observer_archive version name id plant plant_id texts)
  set(folder ${hnav_fmu_folder}/${id})
  hnav_archive_places(${version} ${name} ${folder})
  set(inside ${stage}/resources/plant/binaries/${platform})
  # The licences are those of the plant, which is ours.
  file(GLOB_RECURSE written CONFIGURE_DEPENDS ${texts}/both/* ${texts}/fmi${version}/*)
  add_custom_command(OUTPUT ${fmu}
    COMMAND ${CMAKE_COMMAND} -E rm -rf ${stage}
    COMMAND ${CMAKE_COMMAND} -E copy_directory ${texts}/both ${stage}
    COMMAND ${CMAKE_COMMAND} -E copy_directory ${texts}/fmi${version} ${stage}
    COMMAND ${CMAKE_COMMAND} -E make_directory ${stage}/binaries/${platform} ${inside}
    COMMAND ${CMAKE_COMMAND} -E copy $<TARGET_FILE:fmi${version}_${id}> ${stage}/binaries/${platform}/${name}.so
    COMMAND ${CMAKE_COMMAND} -E copy $<TARGET_FILE:fmi${version}_${plant_id}> ${inside}/${plant}.so
    COMMAND ${CMAKE_COMMAND} -E copy_directory ${CMAKE_CURRENT_BINARY_DIR}/stage/fmi${version}/${plant}/documentation/licenses
            ${stage}/documentation/licenses
    COMMAND ${CMAKE_COMMAND} -E copy ${icons} ${stage}/${icons_to}
    COMMAND ${CMAKE_COMMAND} -E chdir ${stage} ${CMAKE_COMMAND} -E tar cf ${fmu} --format=zip .
    DEPENDS ${written} ${folder}/icon.png ${folder}/icon.svg fmi${version}_${id} ${CMAKE_BINARY_DIR}/fmus/fmi${version}/${plant}.fmu
    COMMENT "FMI ${version}: ${name}.fmu" VERBATIM)
  add_custom_target(fmu${version}_${id} DEPENDS ${fmu})
  add_dependencies(fmus fmu${version}_${id})
endfunction()
