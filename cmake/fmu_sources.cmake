# Run by an FMU's archive: puts what it is compiled from into STAGE/sources, so that `fmpy`, an importer or one call of a C++17
# compiler makes the binary of another platform. FMI headers are the compiler's side. One file includes almost all others; the
# option tables have names in common and are files of their own. There is no SUNDIALS: what it integrates goes by closed forms.
#   TOP, EIGEN (folder that holds Eigen/), STAGE, VERSION (2 or 3), NAME, FOLDER (of the FMU), FILTER (the folder in c_src/attitude,
#   or ins)
set(sources ${STAGE}/sources)
file(COPY ${TOP}/fmu/adapter ${TOP}/fmu/attitude_filter ${TOP}/fmu/${FOLDER} DESTINATION ${sources}
     FILES_MATCHING PATTERN "*.cpp" PATTERN "*.hpp"
     PATTERN "describe.cpp" EXCLUDE PATTERN "documentation.cpp" EXCLUDE PATTERN "model_description.cpp" EXCLUDE
     PATTERN "reference_run.cpp" EXCLUDE PATTERN "*example_input*" EXCLUDE)
if(FILTER STREQUAL ins)
  # Beside the FMU's own files, of which none has the name of one of these.
  file(COPY ${TOP}/c_src/ins DESTINATION ${sources})
  file(GLOB core RELATIVE ${sources} ${sources}/ins/*.cpp)
  list(REMOVE_ITEM core ins/model.cpp)
  set(calls ins.cpp ins_outputs.cpp options.cpp)
else()
  file(COPY ${TOP}/c_src/attitude/common ${TOP}/c_src/attitude/${FILTER} DESTINATION ${sources}/attitude)
  file(GLOB core RELATIVE ${sources} ${sources}/attitude/*/*.cpp)
  # First: it makes the members of the model that are defined by then; those of the other files it would make a second time.
  list(REMOVE_ITEM core attitude/${FILTER}/model.cpp)
  list(PREPEND core attitude/${FILTER}/model.cpp)
  set(calls ${FILTER}.cpp hnav.cpp hybrid_view.cpp options.cpp saved_filter.cpp shown_along.cpp)
endif()
file(COPY ${TOP}/c_src/base ${TOP}/c_src/maths DESTINATION ${sources} FILES_MATCHING PATTERN "*.hpp")
file(COPY ${TOP}/c_src/include/hnav DESTINATION ${sources})
file(COPY ${TOP}/c_src/base/option_list.cpp DESTINATION ${sources}/base)
file(GLOB boundary ${TOP}/c_src/c_api/*.hpp)
list(TRANSFORM boundary REPLACE "^.*/" "")
foreach(file ${boundary} ${calls} version.cpp)
  file(COPY ${TOP}/c_src/c_api/${file} DESTINATION ${sources}/c_api)
endforeach()
file(COPY ${TOP}/c_src/hybrid DESTINATION ${sources} FILES_MATCHING PATTERN "*.hpp" PATTERN "propagator_*.cpp")
file(COPY ${TOP}/c_src/options DESTINATION ${sources} FILES_MATCHING PATTERN "*.hpp" PATTERN "*.cpp")
foreach(module Core Cholesky Eigenvalues Geometry Householder Jacobi LU QR SVD)
  file(COPY ${EIGEN}/Eigen/${module} DESTINATION ${sources}/Eigen)
  file(COPY ${EIGEN}/Eigen/src/${module} DESTINATION ${sources}/Eigen/src)
endforeach()
file(COPY ${EIGEN}/Eigen/src/plugins DESTINATION ${sources}/Eigen/src)
file(COPY ${EIGEN}/Eigen/src/misc DESTINATION ${sources}/Eigen/src PATTERN "blas.h" EXCLUDE PATTERN "lapack*.h" EXCLUDE)

file(GLOB files RELATIVE ${sources} ${sources}/c_api/*.cpp ${sources}/hybrid/*.cpp ${sources}/base/*.cpp)
set(text "// All of ${NAME} but its option tables.\n#define HNAV_FMU_NAME \"${NAME}\"\n#define HNAV_FMU_ARRAYS 0\n")
string(APPEND text "#if defined(_WIN32)\n#define _USE_MATH_DEFINES\n#endif\n")
foreach(file adapter/fmi${VERSION}.cpp adapter/instance.cpp adapter/model_exchange.cpp adapter/saved_state.cpp ${FOLDER}/model.cpp
        ${core} ${files})
  string(APPEND text "#include \"${file}\"\n")
endforeach()
file(WRITE ${sources}/fmu.cpp "${text}")
math(EXPR other "5 - ${VERSION}")
file(REMOVE ${sources}/adapter/fmi${other}.cpp)
