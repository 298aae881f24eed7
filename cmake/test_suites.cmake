# SPDX-License-Identifier: GPL-3.0-or-later
# thermotwin_test_suites(PROGRAM [NAME word] [COST seconds] [SETUP Suite.Test] [FIXTURE name])
# One test of ctest for each suite of a GoogleTest program, named WORD.Suite: tests of a suite share a process, its
# start and what its fixture has made. With SETUP, this one test runs before all others, as the fixture of that name.
# Of two programs the suites of the one with more COST start first, so that long ones do not end alone.
# Suites are listed when ctest starts, so that a new one needs no new configuration.
function(thermotwin_test_suites program)
  cmake_parse_arguments(PARSE_ARGV 1 of "" "NAME;COST;SETUP;FIXTURE" "")
  set(file ${CMAKE_CURRENT_BINARY_DIR}/${program}_suites.cmake)
  file(GENERATE OUTPUT ${file} CONTENT "set(program [==[$<TARGET_FILE:${program}>]==])
set(name [==[${of_NAME}]==])
set(cost [==[${of_COST}]==])
set(setup [==[${of_SETUP}]==])
set(fixture [==[${of_FIXTURE}]==])
include([==[${CMAKE_SOURCE_DIR}/cmake/list_suites.cmake]==])
")
  set_property(DIRECTORY APPEND PROPERTY TEST_INCLUDE_FILES ${file})
endfunction()
