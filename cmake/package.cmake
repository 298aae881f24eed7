# SPDX-License-Identifier: GPL-3.0-or-later
# Debian packages by CPack: thermotwin (program, cases, documents), thermotwin-dev (headers, libraries, examples) and,
# where LinuxCNC is installed, thermotwin-nc (the helper of the verb nc).
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME thermotwin)
set(CPACK_PACKAGE_CONTACT "thermotwin maintainers")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "thermal digital twin of machine tools")
set(CPACK_PACKAGE_DIRECTORY ${CMAKE_BINARY_DIR}/packages)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL program development)
if(TARGET thermotwin_rs274)
  list(APPEND CPACK_COMPONENTS_ALL nc)
endif()
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)

set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME thermotwin)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SUGGESTS "thermotwin-nc, calculix-ccx, paraview, xvfb, xauth")
set(CPACK_COMPONENT_PROGRAM_DESCRIPTION
  "A transient thermo-elastic finite-element model of a machine tool, reduced to a small
state-space model that predicts the error at the tool centre point beside a control,
and a diagnosis that names what a measurement shows to be wrong with the model.
.
This package contains the program, example machines and the documentation.")

set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME thermotwin-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
# What cmake/thermotwin-config.cmake.in finds.
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "thermotwin (= ${PROJECT_VERSION}), g++, cmake, \
libeigen3-dev, libfmt-dev, libmuparser-dev, libopenblas-dev, libsuitesparse-dev, nlohmann-json3-dev")
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION
  "Headers, static libraries, a CMake package and numbered example programs.")

set(CPACK_DEBIAN_NC_PACKAGE_NAME thermotwin-nc)
set(CPACK_DEBIAN_NC_PACKAGE_DEPENDS "thermotwin (= ${PROJECT_VERSION}), linuxcnc-uspace")
set(CPACK_COMPONENT_NC_DESCRIPTION "LinuxCNC's interpreter as a helper process of `thermotwin nc`.")

# A package for newer processors is refused by others before anything is installed.
if(THERMOTWIN_ARCH STREQUAL "x86-64-v3")
  set(CPACK_DEBIAN_PROGRAM_PACKAGE_CONTROL_EXTRA ${CMAKE_SOURCE_DIR}/cmake/preinst)
  string(APPEND CPACK_COMPONENT_PROGRAM_DESCRIPTION "
.
This build needs a processor of the level x86-64-v3 (AVX2, FMA).")
endif()
include(CPack)
