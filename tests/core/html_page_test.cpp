// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/html_page.h"

#include <gtest/gtest.h>

#include "core/base64.h"

namespace thermotwin::core {
namespace {

TEST(Base64, IsThatOfTheStandard) {
  const auto of = [](const std::string& text) { return base64({text.begin(), text.end()}); };
  EXPECT_EQ(of(""), "");
  EXPECT_EQ(of("f"), "Zg==");
  EXPECT_EQ(of("fo"), "Zm8=");
  EXPECT_EQ(of("foobar"), "Zm9vYmFy");
  std::vector<std::uint8_t> bytes;
  put_bytes<std::uint16_t>(bytes, 0x1234);
  EXPECT_EQ(bytes, (std::vector<std::uint8_t>{0x34, 0x12}));
}

TEST(HtmlPage, EscapesTextAndAlignsNumbers) {
  const std::string table = html_table({{"a<b", "um"}, {"x & y", "-1.5"}, {"z", ""}});
  EXPECT_NE(table.find("<th>a&lt;b</th><th class=\"n\">um</th>"), std::string::npos) << table;
  EXPECT_NE(table.find("<td>x &amp; y</td><td class=\"n\">-1.5</td>"), std::string::npos) << table;
  EXPECT_NE(html_table({{"model", "pose"}, {"grey_box", "X=1,Y=2 C&D"}})
                .find("<td>grey_<wbr>box</td><td>X=1,<wbr>Y=2 C&amp;D</td>"),
            std::string::npos);
  EXPECT_NE(html_title("<script>", "").find("&lt;script&gt;"), std::string::npos);
  EXPECT_NE(html_next_steps({{"why", "a > b"}}).find("a &gt; b"), std::string::npos);
}

TEST(HtmlPage, WritesUnitsWithTheirSigns) {
  EXPECT_EQ(html_sentence("1 um, 2 um/h at 20 degC +- 1 K; 3 W/m2"), "1 µm, 2 µm/h at 20 °C ± 1 K; 3 W/m²");
  EXPECT_EQ(html_sentence("dx_um umbrella degC_max"), "dx_um umbrella degC_max");
}

TEST(HtmlPage, HasTheScriptOfChoicesWhereThereAreSome) {
  EXPECT_EQ(html_document("t", "<p>words</p>").find("<script"), std::string::npos);
  const std::string page = html_document("t", html_choice("id", "which", {{"one", "1"}, {"two", "2"}}));
  EXPECT_NE(page.find("<script"), std::string::npos);
  EXPECT_NE(page.find("data-name=\"two\""), std::string::npos);
}

}  // namespace
}  // namespace thermotwin::core
