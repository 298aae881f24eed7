// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/page_text.h"

#include <gtest/gtest.h>

namespace thermotwin::core {
namespace {

TEST(PageText, UnitsHaveTheirSigns) {
  EXPECT_EQ(unit_text("um/m"), "µm/m");
  EXPECT_EQ(unit_text("degC"), "°C");
  EXPECT_EQ(unit_text("umber"), "umber");
}

TEST(PageText, JsonIsSafeInsideAScriptElement) {
  EXPECT_EQ(json_text("a & b \"q\" \\ µ"), R"("a & b \"q\" \\ µ")");
  EXPECT_EQ(json_text("</script><!--\n"), R"("\u003c/script\u003e\u003c!--\u000a")");
}

}  // namespace
}  // namespace thermotwin::core
