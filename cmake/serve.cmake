# SPDX-License-Identifier: GPL-3.0-or-later
# The processes of `serve` beside the program: the front, which needs no library of the model, and the module that
# serves the page.

# What starts and watches the model process, here and beside LinuxCNC.
add_library(thermotwin_process_link STATIC compensation/linuxcnc/exported/process_link.c)
set_target_properties(thermotwin_process_link PROPERTIES C_STANDARD 99 C_STANDARD_REQUIRED ON C_EXTENSIONS OFF)

file(GLOB front_sources CONFIGURE_DEPENDS tools/serve/front/*.cpp)
add_executable(thermotwin_front ${front_sources} compensation/online/offset_guard.cpp)
target_link_libraries(thermotwin_front PRIVATE thermotwin_core thermotwin_process_link fmt::fmt
  nlohmann_json::nlohmann_json)
set_target_properties(thermotwin_front PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR})
target_link_options(thermotwin_front PRIVATE LINKER:--as-needed)
install(TARGETS thermotwin_front RUNTIME DESTINATION ${thermotwin_module_dir} COMPONENT program)

find_path(HTTPLIB_INCLUDE httplib.h REQUIRED)
find_library(HTTPLIB_LIBRARY cpp-httplib REQUIRED)
thermotwin_module(page_server tools/serve/page_server_module.cpp ${HTTPLIB_LIBRARY} Threads::Threads)
target_include_directories(thermotwin_page_server SYSTEM PRIVATE ${HTTPLIB_INCLUDE})
set_property(SOURCE tools/serve/serve.cpp APPEND PROPERTY
  COMPILE_DEFINITIONS THERMOTWIN_HELPERS="${thermotwin_modules_from_program}")
