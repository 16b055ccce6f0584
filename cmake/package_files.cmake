# Run by cpack when the components are staged and before they are packed: every package has its copyright and changelog,
# and man pages are compressed, as Debian wants it.
set(source ${CMAKE_CURRENT_LIST_DIR}/..)
set(of_tessera tessera)
set(of_tesserad tesserad)
set(of_library ${CPACK_DEBIAN_LIBRARY_PACKAGE_NAME})
set(of_development ${CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME})
set(of_python ${CPACK_DEBIAN_PYTHON_PACKAGE_NAME})

function(compress)
  execute_process(COMMAND gzip -9nf ${ARGN} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)  # SOURCE_DATE_EPOCH's, if it is set
foreach(component IN LISTS CPACK_COMPONENTS_ALL)
  set(stage ${CPACK_TEMPORARY_DIRECTORY}/${component})
  set(package ${of_${component}})
  set(documents ${stage}/usr/share/doc/${package})
  configure_file(${source}/deploy/debian/copyright ${documents}/copyright COPYONLY)
  file(WRITE ${documents}/changelog "tessera (${CPACK_PACKAGE_VERSION}) unstable; urgency=medium\n\n  * What users notice: \
CHANGELOG.md, in the package tessera.\n\n -- ${CPACK_PACKAGE_CONTACT}  ${date}\n")
  compress(${documents}/changelog)
  file(GLOB_RECURSE pages ${stage}/usr/share/man/*.[1-9])
  if(pages)
    compress(${pages})
  endif()
endforeach()
