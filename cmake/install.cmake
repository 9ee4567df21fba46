# install: headers, shared and static library, find_package(hnav) and pkg-config.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

install(TARGETS hnav hnav_static EXPORT hnavTargets
        LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(DIRECTORY ${PROJECT_SOURCE_DIR}/c_src/include/hnav DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(EXPORT hnavTargets NAMESPACE hnav:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/hnav)

# The static library needs the SUNDIALS objects too: they are installed beside it under names of their own.
get_target_property(hnav_sundials_libraries hnav_sundials INTERFACE_LINK_LIBRARIES)
set(HNAV_SUNDIALS_NAMES "")
foreach(library ${hnav_sundials_libraries})
  if(library MATCHES "/lib(sundials_[a-z]+)\\.a$")
    install(FILES ${library} DESTINATION ${CMAKE_INSTALL_LIBDIR}/hnav)
    list(APPEND HNAV_SUNDIALS_NAMES ${CMAKE_MATCH_1})
  endif()
endforeach()

configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/hnavConfig.cmake.in ${CMAKE_CURRENT_BINARY_DIR}/hnavConfig.cmake
                              PATH_VARS CMAKE_INSTALL_LIBDIR
                              INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/hnav)
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/hnavConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/hnavConfig.cmake ${CMAKE_CURRENT_BINARY_DIR}/hnavConfigVersion.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/hnav)

# What a static link by a C compiler needs behind -lhnav.
set(HNAV_STATIC_LIBRARIES "")
if(HNAV_SUNDIALS_NAMES)
  list(JOIN HNAV_SUNDIALS_NAMES " -l" hnav_sundials_linked)
  set(HNAV_STATIC_LIBRARIES "-L\${libdir}/hnav -l${hnav_sundials_linked} ")
endif()
string(APPEND HNAV_STATIC_LIBRARIES "-lstdc++ -lm")
# By its own place, so that an unpacked archive works wherever it lies.
file(RELATIVE_PATH HNAV_PREFIX_FROM_PC "/prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig" "/prefix")
configure_file(${PROJECT_SOURCE_DIR}/cmake/hnav.pc.in ${CMAKE_CURRENT_BINARY_DIR}/hnav.pc @ONLY)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/hnav.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/hnav)
if(HNAV_SUNDIALS_LICENSE)
  install(FILES ${HNAV_SUNDIALS_LICENSE} DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/hnav RENAME LICENSE.SUNDIALS)
endif()
# A release says what else is inside (release/sbom.py).
install(FILES ${CMAKE_BINARY_DIR}/hnav.cdx.json DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/hnav OPTIONAL)
