# SPDX-License-Identifier: GPL-3.0-or-later
# Libraries without a CMake package of their own, for the build and for find_package(thermotwin).
# Of HDF5 the library alone is linked: its own module adds what a static one would need.
set(thermotwin_missing "")
foreach(library cholmod umfpack muparser ${thermotwin_of_modules})
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
