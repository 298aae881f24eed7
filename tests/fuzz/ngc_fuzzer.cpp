// SPDX-License-Identifier: GPL-3.0-or-later
// Any bytes are lines of a program. Their words lie in the text in order, the lines together are the text, and setting
// a coordinate changes that word alone.
#include <cstddef>
#include <cstdint>
#include <string>

#include "nc/rewrite/program_line.h"
#include "tests/fuzz/require.h"

using namespace thermotwin;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  std::string joined;
  const nc::ProgramText program(text);
  for (std::size_t i = 0; i < program.size(); ++i) {
    nc::ProgramLine line = program.line(i);
    joined += line.text + line.end;
    std::size_t at = 0;
    for (const nc::Word& word : line.words) {
      require(word.begin >= at && word.end > word.begin && word.end <= line.text.size(), "words lie in order");
      at = word.end;
    }
    if (line.control || line.label || line.assigns) continue;
    const std::size_t words = line.words.size();
    const bool there = line.find('X') != nullptr;
    const std::string before = there ? line.text.substr(0, line.find('X')->begin) : "";
    line.set('X', "-1.25", "XYZ");
    require(line.find('X') != nullptr && line.find('X')->value == -1.25, "a word that was set reads so");
    require(line.words.size() >= words, "no word is lost");
    require(!there || line.text.starts_with(before), "the text before it stays");
  }
  require(joined == text, "lines and ends are the text");
  return 0;
}
