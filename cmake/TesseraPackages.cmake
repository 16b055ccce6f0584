# Debian packages, by `cpack` in a build of the preset `package` (deploy/try-packages.sh does it all and tries them):
# components of the installation, with what Debian wants beside them (cmake/package_files.cmake). Maintainer scripts
# are those for Python's bytecode, and for ldconfig, which CPack adds to the library.
set(CPACK_GENERATOR DEB)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL tessera library development)
if(TARGET tesserad)
  list(APPEND CPACK_COMPONENTS_ALL tesserad)
endif()
if(TARGET tessera_python)
  list(APPEND CPACK_COMPONENTS_ALL python)
endif()
set(CPACK_SET_DESTDIR ON)  # /etc and /lib are not below the prefix
set(CPACK_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE
                                                WORLD_READ WORLD_EXECUTE)
set(CPACK_PRE_BUILD_SCRIPTS ${CMAKE_CURRENT_LIST_DIR}/package_files.cmake)

set(TESSERA_MAINTAINER "The Tessera developers <tessera@users.noreply.github.com>" CACHE STRING "Of the packages")
set(CPACK_PACKAGE_CONTACT ${TESSERA_MAINTAINER})
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "exact Delaunay triangulations of very large point clouds")
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR}/src/front/api)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

get_target_property(soversion tessera_shared SOVERSION)
set(library libtessera${soversion})
set(same "(= ${PROJECT_VERSION})")

# When they are needed (src/base/crs, src/base/hdf5, src/input/remote): dpkg-shlibdeps does not see them.
set(loaded "libgdal32, libcurl4, libhdf5-103-1")

set(about "Tessera cuts a point cloud into tiles, triangulates them in parallel
within a bound on memory, and gives exactly the Delaunay triangulation
of all points, in 2D or 3D.")

set(CPACK_DEBIAN_TESSERA_PACKAGE_NAME tessera)
set(CPACK_DEBIAN_TESSERA_PACKAGE_SECTION science)
set(CPACK_DEBIAN_TESSERA_PACKAGE_RECOMMENDS ${loaded})
set(CPACK_DEBIAN_TESSERA_PACKAGE_SUGGESTS "tesserad, python3-tessera, bash-completion")
set(CPACK_DEBIAN_TESSERA_DESCRIPTION "${about}
.
This package holds the command and the documents.")

set(CPACK_DEBIAN_TESSERAD_PACKAGE_NAME tesserad)
set(CPACK_DEBIAN_TESSERAD_PACKAGE_SECTION science)
set(CPACK_DEBIAN_TESSERAD_PACKAGE_RECOMMENDS "${loaded}, tessera ${same}, systemd")
set(CPACK_DEBIAN_TESSERAD_PACKAGE_CONTROL_EXTRA ${PROJECT_SOURCE_DIR}/deploy/debian/conffiles)
set(CPACK_DEBIAN_TESSERAD_DESCRIPTION "${about}
.
This package holds the daemon, which takes jobs over HTTP, and its unit
for systemd, which the installation does not enable.")

set(CPACK_DEBIAN_LIBRARY_PACKAGE_NAME ${library})
set(CPACK_DEBIAN_LIBRARY_PACKAGE_SECTION libs)
set(CPACK_DEBIAN_LIBRARY_PACKAGE_RECOMMENDS ${loaded})
# Not CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS: it knows the library alone and warns of the Python module; and no trigger.
set(control ${PROJECT_BINARY_DIR}/deploy/debian)
file(WRITE ${control}/shlibs "libtessera ${soversion} ${library} ${same}\n")
file(WRITE ${control}/triggers "activate-noawait ldconfig\n")
set(CPACK_DEBIAN_LIBRARY_PACKAGE_CONTROL_EXTRA ${control}/shlibs ${control}/triggers)
set(CPACK_DEBIAN_LIBRARY_DESCRIPTION "${about}
.
This package holds the shared library.")

set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libtessera-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "${library} ${same}")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SUGGESTS tessera)
set(CPACK_DEBIAN_DEVELOPMENT_DESCRIPTION "${about}
.
This package holds the headers, and what CMake and pkg-config need.")

set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-tessera)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
if(TARGET tessera_python)
  find_package(Python3 REQUIRED COMPONENTS Interpreter)
  math(EXPR next "${Python3_VERSION_MINOR} + 1")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "${library} ${same}, python3-numpy, \
python3 (>= 3.${Python3_VERSION_MINOR}~), python3 (<< 3.${next}~)")
endif()
set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA ${PROJECT_SOURCE_DIR}/deploy/debian/python/postinst
                                              ${PROJECT_SOURCE_DIR}/deploy/debian/python/prerm)
set(CPACK_DEBIAN_PYTHON_DESCRIPTION "${about}
.
This package holds the Python module tessera.")

include(CPack)
