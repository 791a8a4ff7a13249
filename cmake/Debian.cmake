# The Debian package, from the three build trees of ./run package. Included in the tree of level 2, which also provides the files that are not compiled.
#   cpack --config build/package-v2/CPackConfig.cmake -B build/package
set(generated ${PROJECT_BINARY_DIR}/packaging)
# The maintainer: distributors set the environment variables of Debian's own tools. The project itself has no mail address.
if(DEFINED ENV{DEBEMAIL})
  set(CPACK_PACKAGE_CONTACT "$ENV{DEBFULLNAME} <$ENV{DEBEMAIL}>")
else()
  set(CPACK_PACKAGE_CONTACT "the libmpm authors <libmpm@localhost>")
endif()
add_custom_target(mpm_package_files ALL
  COMMAND /usr/bin/python3 ${PROJECT_SOURCE_DIR}/packaging/generate.py $<TARGET_FILE:mpm-app> ${generated}
  COMMAND /usr/bin/python3 ${PROJECT_SOURCE_DIR}/packaging/documents.py ${generated}/documents
  COMMAND ${CMAKE_COMMAND} -D SOURCE_DIR=${PROJECT_SOURCE_DIR} -D OUT=${generated} -D VERSION=${PROJECT_VERSION}
          "-DCONTACT=${CPACK_PACKAGE_CONTACT}" -P ${PROJECT_SOURCE_DIR}/packaging/compress.cmake
  DEPENDS mpm-app VERBATIM)

# The package contains the program; headers and static libraries are for those who build from source.
install(TARGETS mpm-app RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT package)
install(DIRECTORY ${generated}/man/ DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT package)
install(FILES ${generated}/completion/mpm DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions COMPONENT package)
install(FILES ${generated}/case.schema.json DESTINATION ${CMAKE_INSTALL_DATADIR}/mpm COMPONENT package)
install(DIRECTORY examples DESTINATION ${CMAKE_INSTALL_DATADIR}/mpm COMPONENT package PATTERN "__pycache__" EXCLUDE PATTERN "*.md" EXCLUDE)
install(DIRECTORY ${generated}/documents/examples/ DESTINATION ${CMAKE_INSTALL_DATADIR}/mpm/examples COMPONENT package)
install(PROGRAMS scripts/plot_run.py scripts/design_page.py scripts/render_paraview.py DESTINATION ${CMAKE_INSTALL_DATADIR}/mpm/scripts COMPONENT package)
install(DIRECTORY python/mpmtools DESTINATION lib/python3/dist-packages COMPONENT package PATTERN "__pycache__" EXCLUDE)
install(DIRECTORY ${generated}/documents/doc/ DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/mpm COMPONENT package)
install(FILES ${generated}/changelog.gz DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/mpm COMPONENT package)
install(FILES LICENSE RENAME copyright DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/mpm COMPONENT package)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME mpm)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_VENDOR "the libmpm authors")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "snow avalanches on masts by the Material Point Method")
set(CPACK_DEBIAN_PACKAGE_DESCRIPTION
  "mpm computes how a snow avalanche flows against a mast, a pylon or a wall,
in three dimensions, with the explicit Material Point Method: how high the
snow climbs, up to which height it presses, and with what force.
.
The package holds the program, compiled for three levels of x86-64 (the
dynamic linker takes the best one), the Python package mpmtools, and examples.")
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR}/app)
set(CPACK_DEBIAN_PACKAGE_DEPENDS "python3 (>= 3.11)") # for the scripts; the packages that they import are recommended
# For pictures, pages and the Python package; runs work without.
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "python3-numpy, python3-scipy, python3-pandas, python3-matplotlib, python3-h5py, python3-jinja2")
set(CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA "${PROJECT_SOURCE_DIR}/packaging/postinst;${PROJECT_SOURCE_DIR}/packaging/prerm")
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION TRUE)
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "paraview, slurm-client, bash-completion")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_STRIP_FILES ON)
# One package from the component `package` of this tree and the component `level` of each of the three.
cmake_path(GET PROJECT_BINARY_DIR PARENT_PATH builds)
set(CPACK_INSTALL_CMAKE_PROJECTS "${PROJECT_BINARY_DIR};mpm;package;/" "${builds}/package-v2;mpm;level;/" "${builds}/package-v3;mpm;level;/"
    "${builds}/package-v4;mpm;level;/")
set(CPACK_DEB_COMPONENT_INSTALL OFF)
include(CPack)
