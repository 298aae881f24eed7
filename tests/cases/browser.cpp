// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/cases/browser.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <regex>

#include "core/file.h"

namespace thermotwin::cases {

std::string browser() {
  for (const char* name : {"chromium", "chromium-browser", "google-chrome"})
    if (std::system((std::string("command -v ") + name + " >/dev/null 2>&1").c_str()) == 0) return name;
  return "";
}

std::string Page::attribute(const std::string& name) const {
  std::smatch found;
  return std::regex_search(document, found, std::regex(name + "=\"([^\"]*)\"")) ? found[1].str() : "";
}

std::string Page::attribute_of(const std::string& id, const std::string& name) const {
  const auto at = document.find("id=\"" + id + "\"");
  if (at == std::string::npos) return "";
  const auto end = document.find('>', at), place = document.find(name + "=\"", at);
  if (place == std::string::npos || place > end) return "";
  const auto first = place + name.size() + 2;
  return document.substr(first, document.find('"', first) - first);
}

Page opened(const std::filesystem::path& file, const std::string& hash, const std::filesystem::path& folder) {
  const std::filesystem::path out = folder / "page.html", log = folder / "page.log", home = folder / "browser";
  const std::string command =
      browser() +
      " --headless --no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking "
      "--disable-component-update --disable-sync --enable-logging=stderr --user-data-dir='" +
      home.string() + "' --virtual-time-budget=5000 --dump-dom 'file://" + std::filesystem::absolute(file).string() +
      hash + "' >'" + out.string() + "' 2>'" + log.string() + "'";
  EXPECT_EQ(std::system(command.c_str()), 0);
  Page page{core::read_file(out), core::read_file(log)};
  std::filesystem::remove_all(home);
  return page;
}

Page followed(const std::string& address, const std::filesystem::path& folder) {
  const std::filesystem::path out = folder / "page.html", log = folder / "page.log", home = folder / "browser";
  std::filesystem::create_directories(folder);
  const std::string command =
      "timeout 60 " + browser() +
      " --headless --no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking "
      "--disable-component-update --disable-sync --enable-logging=stderr --user-data-dir='" +
      home.string() + "' --virtual-time-budget=3000 --dump-dom '" + address + "' >'" + out.string() + "' 2>'" +
      log.string() + "'";
  EXPECT_EQ(std::system(command.c_str()), 0);
  Page page{core::read_file(out), core::read_file(log)};
  std::filesystem::remove_all(home);
  return page;
}

void expect_self_contained(const std::filesystem::path& file) {
  ASSERT_TRUE(std::filesystem::exists(file)) << file;
  EXPECT_LT(std::filesystem::file_size(file), 5U * 1024 * 1024) << file;
  const std::string text = core::read_file(file);
  // Names of namespaces alone.
  for (auto at = text.find("http"); at != std::string::npos; at = text.find("http", at + 4)) {
    const std::string here = text.substr(at, 22);
    EXPECT_TRUE(here.starts_with("http://www.w3.org/2000") || here.find("://") == std::string::npos) << here;
  }
  for (const char* outside : {"src=", "<link", "@import", "url(", "fetch(", "XMLHttpRequest"})
    EXPECT_EQ(text.find(outside), std::string::npos) << file << " has " << outside;
  EXPECT_NE(text.find("</html>"), std::string::npos) << file;
}

void expect_turns_and_zooms(const std::filesystem::path& file, const std::string& canvas,
                            const std::filesystem::path& folder) {
  // A hand on the mouse: checksums of the pictures before, after a drag and after a turn of the wheel.
  const std::string hand = R"(<script>
    (function () {
      const canvas = document.getElementById(")" +
                           canvas + R"(");
      const picture = () => canvas.toDataURL().split("").reduce((sum, c) => (31 * sum + c.charCodeAt(0)) % 2147483647,
        7);
      const mouse = (kind, x, y) => canvas.dispatchEvent(new PointerEvent(kind, { clientX: x, clientY: y }));
      canvas.setPointerCapture = () => {};               // there is no such pointer
      window.requestAnimationFrame = draw => { draw(); };  // without a frame in between
      canvas.dataset.before = picture();
      mouse("pointermove", 300, 200);
      canvas.dataset.hovered = picture();
      mouse("pointerdown", 300, 200); mouse("pointermove", 380, 230); mouse("pointerup", 380, 230);
      canvas.dataset.turned = picture();
      canvas.dispatchEvent(new WheelEvent("wheel", { deltaY: -400, cancelable: true }));
      canvas.dataset.zoomed = picture();
    })();
    </script></html>)";
  const std::filesystem::path copy = folder / "by_hand.html";
  std::string text = core::read_file(file);
  const auto end = text.rfind("</html>");
  ASSERT_NE(end, std::string::npos) << file;
  core::write_file(copy, text.substr(0, end) + hand);
  const Page page = opened(copy, "", folder);
  expect_quiet(page);
  const auto of = [&](const char* moment) { return page.attribute_of(canvas, moment); };
  EXPECT_NE(of("data-before"), "") << file;
  EXPECT_EQ(of("data-hovered"), of("data-before")) << file << ": moves without a button";
  EXPECT_NE(of("data-turned"), of("data-before")) << file;
  EXPECT_NE(of("data-zoomed"), of("data-turned")) << file;
  EXPECT_NE(of("data-zoomed"), "") << file;
}

void expect_quiet(const Page& page) {
  EXPECT_EQ(page.log.find(":CONSOLE"), std::string::npos) << page.log;
  EXPECT_NE(page.document.find("</html>"), std::string::npos);
}

}  // namespace thermotwin::cases
