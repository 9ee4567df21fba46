# The C headers as the Python package knows them: hnav/native/_hnav.py, made by cffi. In a checkout it lies among the sources and
# comes from the environment of ./run; pip (SKBUILD) has an environment of its own, and leaves the sources as they are.
set(hnav_python_default ${PROJECT_SOURCE_DIR}/.venv/bin/python)
set(binding ${PROJECT_SOURCE_DIR}/python/hnav/native/_hnav.py)
if(SKBUILD)
  set(hnav_python_default ${PYTHON_EXECUTABLE})
  set(binding ${CMAKE_BINARY_DIR}/_hnav.py)
endif()
set(HNAV_PYTHON ${hnav_python_default} CACHE FILEPATH "Python with cffi, which makes the binding of the package")

file(GLOB_RECURSE read CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/c_src/include/hnav/*.h)
set(reader ${PROJECT_SOURCE_DIR}/python/hnav/native/headers.py)
add_custom_command(OUTPUT ${binding}
  COMMAND ${HNAV_PYTHON} ${reader} --compiler ${CMAKE_C_COMPILER} --include ${PROJECT_SOURCE_DIR}/c_src/include
          --output ${binding}
  DEPENDS ${reader} ${read} VERBATIM
  COMMENT "Python binding from the C headers")
add_custom_target(python_binding DEPENDS ${binding})
