// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/module.h"

#include <gtest/gtest.h>

#include <string>

#include "core/error.h"

namespace thermotwin::core {
namespace {

std::string refusal(const char* module, const char* function) {
  try {
    module_function(module, function, "mesher", "install the program again");
  } catch (const SolverError& error) {
    return error.what();
  }
  return "loaded";
}

TEST(Module, AFunctionIsFoundByItsName) {
  auto* root = reinterpret_cast<double (*)(double)>(module_function("libm.so.6", "cbrt", "test", ""));
  EXPECT_DOUBLE_EQ(root(27.0), 3.0);
}

TEST(Module, OneThatIsNotThereIsNamedWithWhatToDo) {
  const std::string text = refusal("libthermotwin_of_nobody.so", "f");
  EXPECT_EQ(text.find("mesher: libthermotwin_of_nobody.so cannot be loaded ("), 0U) << text;
  EXPECT_NE(text.find("; install the program again"), std::string::npos) << text;
}

TEST(Module, AFunctionThatItDoesNotHaveIsNamed) {
  EXPECT_NE(refusal("libm.so.6", "function_of_nobody").find("function_of_nobody"), std::string::npos);
}

}  // namespace
}  // namespace thermotwin::core
