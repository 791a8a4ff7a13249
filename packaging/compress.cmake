# Man pages and the changelog as Debian wants them: compressed, without a time, so that the same sources give the same bytes.
file(GLOB pages ${OUT}/man/*.1)
file(REMOVE ${OUT}/changelog.gz)
configure_file(${SOURCE_DIR}/CHANGELOG.md ${OUT}/changelog COPYONLY)
foreach(file IN LISTS pages ITEMS ${OUT}/changelog)
  file(REMOVE ${file}.gz)
  execute_process(COMMAND gzip -9 -n ${file} COMMAND_ERROR_IS_FATAL ANY)
endforeach()
