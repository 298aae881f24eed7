# SPDX-License-Identifier: GPL-3.0-or-later
# Libraries without a CMake package of their own, for the build and for find_package(thermotwin).
# HDF5's own module wants a C compiler, which a C++ program need not have.
set(thermotwin_missing "")
foreach(library gmsh cholmod umfpack hdf5)
  string(TOUPPER ${library} upper)
  find_library(${upper}_LIBRARY NAMES ${library} ${library}_serial PATH_SUFFIXES hdf5/serial)
  mark_as_advanced(${upper}_LIBRARY)
  if(NOT ${upper}_LIBRARY)
    string(APPEND thermotwin_missing " lib${library}")
  elseif(NOT TARGET thermotwin::${library})
    add_library(thermotwin::${library} UNKNOWN IMPORTED)
    set_target_properties(thermotwin::${library} PROPERTIES IMPORTED_LOCATION ${${upper}_LIBRARY})
  endif()
endforeach()
