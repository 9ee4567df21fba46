# What `pip install .` puts beside the modules of python/hnav, as hnav.places expects it: library, binding, FMUs and models.
install(FILES $<TARGET_FILE:hnav> DESTINATION hnav RENAME libhnav${CMAKE_SHARED_LIBRARY_SUFFIX} COMPONENT python)
install(FILES ${binding} DESTINATION hnav/native COMPONENT python)
install(DIRECTORY ${CMAKE_BINARY_DIR}/fmus DESTINATION hnav COMPONENT python FILES_MATCHING PATTERN *.fmu)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/models DESTINATION hnav COMPONENT python)
install(FILES ${HNAV_SUNDIALS_LICENSE} DESTINATION ${SKBUILD_METADATA_DIR}/licenses RENAME LICENSE.SUNDIALS COMPONENT python)
