# The C headers as the Python package knows them: python/hnav/native/_hnav.py, made by cffi in the environment of ./run.
set(HNAV_PYTHON ${PROJECT_SOURCE_DIR}/.venv/bin/python CACHE FILEPATH "Python with cffi, which makes the binding of the package")

set(binding ${PROJECT_SOURCE_DIR}/python/hnav/native/_hnav.py)
set(reader ${PROJECT_SOURCE_DIR}/python/hnav/native/headers.py)
add_custom_command(OUTPUT ${binding}
  COMMAND ${HNAV_PYTHON} ${reader} --compiler ${CMAKE_C_COMPILER} --include ${PROJECT_SOURCE_DIR}/c_src/include
          --output ${binding} --depfile ${CMAKE_CURRENT_BINARY_DIR}/python_binding.d
  DEPENDS ${reader} DEPFILE ${CMAKE_CURRENT_BINARY_DIR}/python_binding.d VERBATIM
  COMMENT "Python binding from the C headers")
add_custom_target(python_binding DEPENDS ${binding})
