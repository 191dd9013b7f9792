# CPack runs this on the installed files before it packs them. Debian wants a change log and compressed manual pages.
string(TIMESTAMP DATE "%a, %d %b %Y %H:%M:%S +0000" UTC)  # or SOURCE_DATE_EPOCH
foreach(package terrazzo terrazzo-dev python3-terrazzo)
  file(GLOB folder ${CPACK_TEMPORARY_DIRECTORY}/*/usr/share/doc/${package})
  if(NOT folder)
    continue()
  endif()
  file(WRITE ${folder}/changelog
    "terrazzo (${CPACK_PACKAGE_VERSION}) unstable; urgency=medium\n\n  * Version ${CPACK_PACKAGE_VERSION}.\n\n"
    " -- ${CPACK_PACKAGE_CONTACT}  ${DATE}\n")
endforeach()
file(GLOB FILES ${CPACK_TEMPORARY_DIRECTORY}/*/usr/share/man/man*/* ${CPACK_TEMPORARY_DIRECTORY}/*/usr/share/doc/*/changelog)
foreach(file ${FILES})
  execute_process(COMMAND gzip --best --no-name --force ${file} COMMAND_ERROR_IS_FATAL ANY)
endforeach()
