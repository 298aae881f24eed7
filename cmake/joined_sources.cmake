# SPDX-License-Identifier: GPL-3.0-or-later
# Compiles a few neighbouring sources of a room as one, so that what they include is read once. A group is small enough
# that a change of one source is compiled again in seconds.
#
# thermotwin_join(target source ...): sources of one folder, in the order of their names.

set(thermotwin_joined 3)  # sources at most in a group

# Sources that bring names along which others must not see: wrappers of large libraries.
set(thermotwin_alone "#include <(vtk|assimp|gmsh|hdf5|umfpack|suitesparse|petsc|muParser|unistd|sys/|dlfcn)")

function(thermotwin_join target)
  if(NOT THERMOTWIN_JOINED)
    return()
  endif()
  set(room "")
  set(groups 0)
  list(SORT ARGN)
  foreach(source IN LISTS ARGN)
    if(NOT source MATCHES "\\.cpp$")
      continue()
    endif()
    file(STRINGS ${source} alone REGEX "${thermotwin_alone}" LIMIT_COUNT 1)
    if(alone)
      set_property(SOURCE ${source} PROPERTY SKIP_UNITY_BUILD_INCLUSION ON)
      continue()
    endif()
    get_filename_component(folder ${source} DIRECTORY)
    if(NOT folder STREQUAL room OR count EQUAL thermotwin_joined)
      set(room ${folder})
      set(count 0)
      math(EXPR groups "${groups} + 1")
    endif()
    math(EXPR count "${count} + 1")
    set_property(SOURCE ${source} PROPERTY UNITY_GROUP ${groups})
  endforeach()
  # A source is no header here, and what its unnamed namespace holds stays inside.
  target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
endfunction()
