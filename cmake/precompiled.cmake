# hnav_precompile(TARGET HEADER...): these headers, which nearly every file of the target reads, are compiled once for all of them. A
# third of the time of a build is reading Eigen. Each file still includes what it uses: builds without this have to pass too.
set(precompiled OFF)
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
  set(precompiled ON)
endif()
option(HNAV_PRECOMPILED_HEADERS "Compile the headers of Eigen and GoogleTest once per target" ${precompiled})

function(hnav_precompile target)
  if(HNAV_PRECOMPILED_HEADERS)
    if(ARGV1 STREQUAL REUSE_FROM)
      target_precompile_headers(${target} ${ARGN})
    else()
      target_precompile_headers(${target} PRIVATE ${ARGN})
    endif()
  endif()
endfunction()
