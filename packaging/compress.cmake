# Man pages and the change log as Debian wants them: compressed, without a time of their own, so that the same sources give the same bytes.
file(GLOB pages ${OUT}/man/*.1)
find_package(Git QUIET)
set(date "Thu, 01 Jan 1970 00:00:00 +0000")
if(GIT_FOUND AND EXISTS ${SOURCE_DIR}/.git)
  execute_process(COMMAND ${GIT_EXECUTABLE} -C ${SOURCE_DIR} log -1 --format=%aD OUTPUT_VARIABLE date OUTPUT_STRIP_TRAILING_WHITESPACE
                  COMMAND_ERROR_IS_FATAL ANY)
endif()
file(WRITE ${OUT}/changelog "mpm (${VERSION}) unstable; urgency=medium\n\n  * See CHANGELOG.md.\n\n -- ${CONTACT}  ${date}\n")
foreach(file IN LISTS pages ITEMS ${OUT}/changelog)
  file(REMOVE ${file}.gz)
  execute_process(COMMAND gzip -9 -n ${file} COMMAND_ERROR_IS_FATAL ANY)
endforeach()
