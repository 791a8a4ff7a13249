# cmake --install: library, headers and CMake package; the command mpm; scripts, Python package and examples under share/mpm.
# cmake --install --component core: only the layer mpm::core, which needs only the target mpm_core to be built.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

# Each layer is a component: find_package(mpm COMPONENTS core) requires only Eigen and OpenMP.
get_property(layers GLOBAL PROPERTY MPM_LAYERS)
foreach(layer IN LISTS layers)
  string(REPLACE mpm_ "" component ${layer})
  install(TARGETS ${layer} EXPORT mpm-${component}-targets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT ${component}
          INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
  get_property(folders GLOBAL PROPERTY MPM_FOLDERS_${component})
  foreach(folder IN LISTS folders)
    install(DIRECTORY libmpm/${folder} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/libmpm COMPONENT ${component} FILES_MATCHING PATTERN "*.hpp"
      PATTERN hdf5_library.hpp EXCLUDE) # for the sources of io alone: it needs headers of HDF5 and zlib
  endforeach()
endforeach()
if(TARGET mpm-app) # mpm-validate is not installed: its cases and references are part of the sources
  install(TARGETS mpm-app RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()
install(DIRECTORY scripts python examples DESTINATION ${CMAKE_INSTALL_DATADIR}/mpm USE_SOURCE_PERMISSIONS PATTERN "__pycache__" EXCLUDE)
install(FILES LICENSE README.md DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/mpm)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/mpm)
configure_package_config_file(cmake/mpm-config.cmake.in ${PROJECT_BINARY_DIR}/mpm-config.cmake INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/mpm-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/mpm-config.cmake ${PROJECT_BINARY_DIR}/mpm-config-version.cmake DESTINATION ${package_dir} COMPONENT core)
foreach(layer IN LISTS layers)
  string(REPLACE mpm_ "" component ${layer})
  install(EXPORT mpm-${component}-targets NAMESPACE mpm:: DESTINATION ${package_dir} COMPONENT ${component})
endforeach()
