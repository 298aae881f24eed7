// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/module.h"

#include <dlfcn.h>
#include <filesystem>
#include <new>
#include <system_error>

#include "core/error.h"

namespace thermotwin::core {

void* module_function(const char* module, const char* function, const std::string& place, const std::string& instead) {
  // An installed program finds it from its own place; else the run path of the program or library that links this
  // one tells where it is (build folder, installed library), or LD_LIBRARY_PATH.
  std::error_code ignored;
  const std::filesystem::path installed =
      std::filesystem::read_symlink("/proc/self/exe", ignored).parent_path() / THERMOTWIN_MODULES / module;
  const bool is_installed = std::filesystem::exists(installed, ignored);
  void* loaded = dlopen(is_installed ? installed.c_str() : module, RTLD_NOW | RTLD_LOCAL);
  void* found = loaded != nullptr ? dlsym(loaded, function) : nullptr;
  if (found != nullptr) return found;
  const char* message = dlerror();
  const std::string error = message != nullptr ? message : "it is not where the program is";
  // The loader's words for an address space that is used up.
  for (const char* words : {"failed to map segment", "annot allocate memory", "cannot map"})
    if (error.find(words) != std::string::npos) throw std::bad_alloc();
  throw SolverError(place + ": " + module + " cannot be loaded (" + error + "); " + instead);
}

}  // namespace thermotwin::core
