# hnav_precompile(...) is target_precompile_headers(...): headers that nearly every file of a target reads are compiled once for all of
# them. A third of the time of a build is reading Eigen. Each file still includes what it uses: builds without this have to pass too.
set(precompiled OFF)
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
  set(precompiled ON)
endif()
option(HNAV_PRECOMPILED_HEADERS "Compile the headers of Eigen and GoogleTest once per target" ${precompiled})

function(hnav_precompile)
  if(HNAV_PRECOMPILED_HEADERS)
    target_precompile_headers(${ARGV})
  endif()
endfunction()
