# hnav_add_ssp(NAME FMUS...): build/ssp/NAME.ssp from the system structure and the parameter sets of models/systems/NAME, and
# the FMUs that it names, FMI 2, which importers of SSP take.
function(hnav_add_ssp name)
  if(NOT hnav_runs_here)
    return()
  endif()
  set(system ${PROJECT_SOURCE_DIR}/models/systems/${name})
  set(stage ${CMAKE_CURRENT_BINARY_DIR}/stage/ssp/${name})
  set(ssp ${CMAKE_BINARY_DIR}/ssp/${name}.ssp)
  set(needed ${system}/SystemStructure.ssd)
  set(copies COMMAND ${CMAKE_COMMAND} -E copy ${system}/SystemStructure.ssd ${stage}/)
  file(GLOB sets CONFIGURE_DEPENDS RELATIVE ${system} ${system}/*/*.ssv)
  foreach(file ${sets})
    list(APPEND needed ${system}/${file})
    get_filename_component(folder ${file} DIRECTORY)
    list(APPEND copies COMMAND ${CMAKE_COMMAND} -E make_directory ${stage}/${folder}
         COMMAND ${CMAKE_COMMAND} -E copy ${system}/${file} ${stage}/${folder}/)
  endforeach()
  foreach(fmu ${ARGN})
    list(APPEND needed ${CMAKE_BINARY_DIR}/fmus/fmi2/${fmu}.fmu)
    list(APPEND copies COMMAND ${CMAKE_COMMAND} -E copy ${CMAKE_BINARY_DIR}/fmus/fmi2/${fmu}.fmu ${stage}/resources/)
  endforeach()
  add_custom_command(OUTPUT ${ssp}
    COMMAND ${CMAKE_COMMAND} -E rm -rf ${stage}
    COMMAND ${CMAKE_COMMAND} -E make_directory ${stage}/resources ${CMAKE_BINARY_DIR}/ssp
    ${copies}
    COMMAND ${CMAKE_COMMAND} -E chdir ${stage} ${CMAKE_COMMAND} -E tar cf ${ssp} --format=zip .
    DEPENDS ${needed} COMMENT "SSP: ${name}.ssp" VERBATIM)
  add_custom_target(ssp_${name} DEPENDS ${ssp})
  add_dependencies(fmus ssp_${name})
endfunction()
