# cmake --install: library, headers and CMake package; the command mpm; scripts and examples under share/mpm.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

install(TARGETS mpm EXPORT mpm-targets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(DIRECTORY libmpm/include/mpm DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.hpp")
if(TARGET mpm-app) # mpm-validate stays here: its cases and references are part of the sources
  install(TARGETS mpm-app RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()
install(DIRECTORY scripts examples DESTINATION ${CMAKE_INSTALL_DATADIR}/mpm USE_SOURCE_PERMISSIONS PATTERN "__pycache__" EXCLUDE)
install(FILES LICENSE README.md DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/mpm)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/mpm)
configure_package_config_file(cmake/mpm-config.cmake.in ${PROJECT_BINARY_DIR}/mpm-config.cmake INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/mpm-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/mpm-config.cmake ${PROJECT_BINARY_DIR}/mpm-config-version.cmake DESTINATION ${package_dir})
install(EXPORT mpm-targets NAMESPACE mpm:: DESTINATION ${package_dir})
