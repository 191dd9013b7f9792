# Settings of `cpack`, which writes three Debian packages: terrazzo (component runtime), terrazzo-dev (component development) and, where the
# Python module is built, python3-terrazzo (component python).
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME terrazzo)
set(CPACK_PACKAGE_CONTACT "Terrazzo maintainers <maintainers@terrazzo.invalid>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY ${PROJECT_DESCRIPTION})
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/package)
set(CPACK_COMPONENTS_ALL runtime development)
if(TERRAZZO_PYTHON)
  list(APPEND CPACK_COMPONENTS_ALL python)
endif()
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_PRE_BUILD_SCRIPTS ${CMAKE_CURRENT_LIST_DIR}/stage.cmake)

set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_NAME terrazzo)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR})
set(CPACK_DEBIAN_RUNTIME_PACKAGE_RECOMMENDS libgl1-mesa-dri)  # for `device: gpu` on machines without a GPU driver
set(CPACK_COMPONENT_RUNTIME_DESCRIPTION
"Terrazzo evaluates node graphs that recover the size, shape and color of
particles from one photograph of an aggregate, pack them into a block that
tiles, and write glTF, OpenVDB and images.
This package contains the program, its libraries and the graphs of materials.")

set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME terrazzo-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS  # the packages that TerrazzoConfig.cmake looks for
  "terrazzo (= ${PROJECT_VERSION}), libboost-iostreams-dev, libeigen3-dev, libfmt-dev, libopenvdb-dev, libtbb-dev")
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION
"This package contains the headers and CMake files for nodes and programs that
are built outside Terrazzo's source tree.")

set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-terrazzo)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "terrazzo (= ${PROJECT_VERSION}), python3 (>= 3.11), python3 (<< 3.12), python3-numpy")
set(CPACK_COMPONENT_PYTHON_DESCRIPTION
"This package contains the Python module terrazzo: graphs, values as numpy
arrays, and nodes written in Python.")

install(FILES ${CMAKE_CURRENT_LIST_DIR}/copyright DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/python3-terrazzo COMPONENT python EXCLUDE_FROM_ALL)
install(FILES ${CMAKE_CURRENT_LIST_DIR}/copyright DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/terrazzo)
install(FILES ${CMAKE_CURRENT_LIST_DIR}/copyright DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/terrazzo-dev
  COMPONENT development)
include(CPack)
