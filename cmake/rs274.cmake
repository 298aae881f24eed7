# SPDX-License-Identifier: GPL-3.0-or-later
# The helper process of `nc`: LinuxCNC's interpreter behind a stream of records. It is built where linuxcnc-uspace and
# linuxcnc-uspace-dev are installed; without it `nc` says so. It is a program of its own under GPL-2.0-or-later.
find_path(LINUXCNC_INCLUDE interp_base.hh PATH_SUFFIXES linuxcnc)
find_library(RS274_LIBRARY rs274)
find_library(PYPLUGIN_LIBRARY pyplugin)
if(LINUXCNC_INCLUDE AND RS274_LIBRARY AND PYPLUGIN_LIBRARY)
  file(GLOB rs274_sources CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/nc/rs274/*.cpp)
  add_executable(thermotwin_rs274 ${rs274_sources})
  target_include_directories(thermotwin_rs274 PRIVATE ${CMAKE_SOURCE_DIR})
  target_include_directories(thermotwin_rs274 SYSTEM PRIVATE ${LINUXCNC_INCLUDE})
  target_compile_options(thermotwin_rs274 PRIVATE -Wall -Wextra)
  target_link_libraries(thermotwin_rs274 PRIVATE ${RS274_LIBRARY} ${PYPLUGIN_LIBRARY} ${CMAKE_DL_LIBS})
  set_target_properties(thermotwin_rs274 PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR})
  add_dependencies(thermotwin_nc thermotwin_rs274)  # who builds the program has its helper as well
  # A package of its own, since it needs LinuxCNC.
  install(TARGETS thermotwin_rs274 RUNTIME DESTINATION ${thermotwin_module_dir} COMPONENT nc)
else()
  message(STATUS "linuxcnc-uspace-dev is not installed: without the verb nc")
endif()
