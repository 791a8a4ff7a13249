# MPM_PACKAGE: the program for a Debian package that runs on every x86-64-v2 processor and at full speed on a newer one.
#
# `mpm` is a stub of one call. Everything else is in one shared library, which is built three times, for x86-64-v2, v3 and v4. The dynamic
# linker chooses the best one for the processor (glibc-hwcaps folders; glibc 2.33 and later):
#   bin/mpm
#   lib/<arch>/mpm/libmpm.so                           x86-64-v2
#   lib/<arch>/mpm/glibc-hwcaps/x86-64-v3/libmpm.so    AVX2, FMA
#   lib/<arch>/mpm/glibc-hwcaps/x86-64-v4/libmpm.so    AVX-512
# The library exports one function with arguments that are the same at each level. Everything else is hidden: arguments with vector
# types are passed differently at each level.
# A build tree makes one level, MPM_PACKAGE_LEVEL; ./run package builds all three and combines them.
set(MPM_PACKAGE_LEVEL 2 CACHE STRING "Level of x86-64 that this tree is built for: 2, 3 or 4")
set(mpm_private_library_dir ${CMAKE_INSTALL_LIBDIR}/mpm)
set(mpm_level_dir ${mpm_private_library_dir})
if(MPM_PACKAGE_LEVEL GREATER 2)
  set(mpm_level_dir ${mpm_private_library_dir}/glibc-hwcaps/x86-64-v${MPM_PACKAGE_LEVEL})
endif()

# mpm_add_program(TARGET SOURCES source... MAIN source): a program whose MAIN calls functions of SOURCES.
function(mpm_add_program target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "MAIN" "SOURCES")
  if(NOT MPM_PACKAGE)
    add_executable(${target} ${arg_MAIN} ${arg_SOURCES})
    set(${target}_code ${target} PARENT_SCOPE)
    return()
  endif()
  add_library(${target}-shared SHARED ${arg_SOURCES})
  set(exports ${PROJECT_SOURCE_DIR}/cmake/package_exports.map)
  target_link_options(${target}-shared PRIVATE LINKER:--version-script=${exports} LINKER:--no-undefined)
  set_target_properties(${target}-shared PROPERTIES OUTPUT_NAME mpm LINK_DEPENDS ${exports})
  add_executable(${target} ${arg_MAIN})
  target_link_libraries(${target} PRIVATE ${target}-shared)
  set_target_properties(${target} PROPERTIES INSTALL_RPATH "\$ORIGIN/../${mpm_private_library_dir}")
  install(TARGETS ${target}-shared LIBRARY DESTINATION ${mpm_level_dir} COMPONENT level)
  set(${target}_code ${target}-shared PARENT_SCOPE)
endfunction()
