// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Modules: shared libraries of this project that bring large libraries of others with them (Gmsh, PETSc). A module is
// loaded when something first asks for it, so that a program that does not need it starts without.

#include <string>

namespace thermotwin::core {

/// Loads a module for the rest of the program.
/// @param module    file name, "libthermotwin_gmsh.so"
/// @param function  name of a function with C linkage
/// @param place     for the message, "multigrid"
/// @param instead   what a user can do without it
/// @return address of the function  @throws SolverError if the module or the function is not there; std::bad_alloc
void* module_function(const char* module, const char* function, const std::string& place, const std::string& instead);

/// Loads a module that every installation has. @param function  without arguments, returns the address of the table
/// @return its table of functions  @throws as module_function
template <class Table>
const Table& module_table(const char* module, const char* function, const std::string& place) {
  void* found = module_function(module, function, place, "install the program again");
  return *reinterpret_cast<const Table* (*)()>(found)();
}

}  // namespace thermotwin::core
