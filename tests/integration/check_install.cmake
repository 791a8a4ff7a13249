# cmake -D BUILD_DIR=... -D WORK_DIR=... -D EXAMPLE_DIR=... [-D CORE_SOURCE_DIR=...] [-D RUN=program] [-D OPTIONS=...] -P check_install.cmake
# Installs BUILD_DIR, or a build of CORE_SOURCE_DIR with MPM_CORE_ONLY, into an empty prefix, builds the project EXAMPLE_DIR against that
# copy, runs its program. Any failure is fatal.
function(must)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE code OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT code EQUAL 0)
    list(JOIN ARGN " " command)
    message(FATAL_ERROR "${output}\nexit code ${code}: ${command}")
  endif()
endfunction()

file(REMOVE_RECURSE ${WORK_DIR})
if(CORE_SOURCE_DIR)
  set(BUILD_DIR ${WORK_DIR}/core)
  must(${CMAKE_COMMAND} -S ${CORE_SOURCE_DIR} -B ${BUILD_DIR} -DMPM_CORE_ONLY=ON ${OPTIONS})
  must(${CMAKE_COMMAND} --build ${BUILD_DIR})
endif()
must(${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${WORK_DIR}/prefix)
must(${CMAKE_COMMAND} -S ${EXAMPLE_DIR} -B ${WORK_DIR}/build -DCMAKE_PREFIX_PATH=${WORK_DIR}/prefix
     -DCMAKE_FIND_PACKAGE_NO_PACKAGE_REGISTRY=ON ${OPTIONS})
must(${CMAKE_COMMAND} --build ${WORK_DIR}/build)
if(RUN)
  must(${WORK_DIR}/build/${RUN})
endif()
