// SPDX-License-Identifier: GPL-3.0-or-later
// Commands, links and commits of the documentation. A page's blocks run in a folder of their own that holds cases and
// tests/cases/toy, with the built program as thermotwin. A block of ```sh runs as it stands. A command of ```sh long
// runs on the toy machine if it names nothing else of a case. The others, and those of ```sh parse, have verbs,
// options and paths that exist. A block of ```text right after one of ```sh shows what its commands said.
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <fstream>
#include <map>
#include <optional>
#include <regex>
#include <set>
#include <sstream>

#include "tests/cases/help.h"
#include "tests/cases/shown_output.h"
#include "tests/cases/texts.h"
#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

constexpr int patience_s = 120;  ///< of one block
const std::string whole_case = "cases/vmc5", toy = "tests/cases/toy";

bool ends_command(char c) { return std::string_view("|&;<>").find(c) != std::string_view::npos; }

/// Words of a command line as a shell parts them; |, &&, ;, < and > are words of their own.
Words words_of(const std::string& line) {
  Words words;
  std::string word;
  bool open = false;
  const auto end = [&] {
    if (open) words.push_back(std::move(word));
    word.clear();
    open = false;
  };
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (c == '"' || c == '\'') {
      open = true;
      for (++i; i < line.size() && line[i] != c; ++i) word += line[i];
    } else if (c == '#' && !open) {
      break;
    } else if (std::isspace(static_cast<unsigned char>(c)) != 0) {
      end();
    } else if (ends_command(c)) {
      end();
      words.emplace_back(1, c);
    } else {
      open = true;
      word += c;
    }
  }
  end();
  return words;
}

/// Calls of thermotwin in a line, without the name itself.
std::vector<Words> calls_in(const std::string& line) {
  std::vector<Words> calls;
  bool inside = false;
  for (const std::string& word : words_of(line)) {
    if (word.size() == 1 && ends_command(word.front())) {
      inside = false;
    } else if (!inside && (word == "thermotwin" || word.ends_with("/thermotwin"))) {
      inside = true;
      calls.emplace_back();
    } else if (inside) {
      calls.back().push_back(word);
    }
  }
  return calls;
}

/// One line for each command: continued lines are joined, comments left out.
std::vector<std::string> commands_of(const CodeBlock& block) {
  std::vector<std::string> commands;
  std::string command;
  for (const std::string& line : block.lines) {
    const std::size_t begin = line.find_first_not_of(' ');
    if (begin == std::string::npos || (command.empty() && line[begin] == '#')) continue;
    command += line.substr(begin);
    if (command.ends_with("\\")) {
      command.back() = ' ';
      continue;
    }
    commands.push_back(std::move(command));
    command.clear();
  }
  return commands;
}

/// VERB, CASE, DATA/drift: to be replaced by the reader.
bool is_placeholder(const std::string& word) {
  const std::string first = word.substr(0, word.find('/'));
  return first == "..." || (first.size() > 1 && std::all_of(first.begin(), first.end(), [](unsigned char c) {
                              return std::isupper(c) != 0 || c == '_';
                            }));
}

std::string fault_of_call(const Words& call) {
  if (call.empty()) return "thermotwin without a verb";
  const std::string& verb = call.front();
  if (verb == "--help" || verb == "--version" || is_placeholder(verb)) return "";
  static const Words known = verbs();
  if (std::find(known.begin(), known.end(), verb) == known.end()) return "unknown verb '" + verb + "'";
  const std::set<std::string> options = options_of(verb);
  for (const std::string& word : call) {
    const std::string name = word.substr(0, word.find('='));
    if (name.size() > 1 && name.starts_with("-") && std::isalpha(static_cast<unsigned char>(name.back())) != 0 &&
        options.count(name) == 0)
      return "unknown option '" + name + "' of " + verb;
  }
  return "";
}

/// Verbs, options, and paths of the tree that a command names. @return empty: none is wrong
std::string fault_of(const std::string& command) {
  for (const Words& call : calls_in(command))
    if (const std::string fault = fault_of_call(call); !fault.empty()) return fault;
  for (const std::string& word : words_of(command)) {
    const bool of_tree =
        word.starts_with("cases/vmc5") || word.starts_with("tests/cases/toy") || word.starts_with("tools/");
    if (of_tree && word.find_first_of("*?{$<") == std::string::npos && !fs::exists(source_tree() / word))
      return "no '" + word + "' in the tree";
  }
  return "";
}

/// Options whose values mean the same with any case.
bool is_general(const std::string& option) {
  static const std::set<std::string> general = {
      "--out",        "--threads",       "--quiet",        "--json",         "--size",
      "--mesh-order", "--order",         "--solver",       "--bound",        "--resume",
      "--compare",    "--exact",         "--fields-every", "--output-times", "--checkpoint-every",
      "--calculix",   "--matrices",      "--heat-only",    "--reduced",      "--perturb",
      "--first-seed", "--measured-size", "--no-sensors",   "--step",         "--strict",
      "--method"};
  return general.count(option) > 0;
}

/// The command on the toy machine; empty where it names more of the whole case than its folder, or a file that is not
/// there.
std::string on_toy(std::string command, const fs::path& folder) {
  const std::vector<Words> calls = calls_in(command);
  if (calls.size() != 1 || words_of(command).front() != "thermotwin") return "";
  const Words& call = calls.front();
  if (std::none_of(call.begin(), call.end(), [](const std::string& word) { return word.starts_with(whole_case); }))
    return "";
  for (std::size_t i = 1; i < call.size(); ++i) {
    const std::string& word = call[i];
    if (!word.starts_with("--") || is_general(word)) continue;
    static const std::set<std::string> of_files = {"--data", "--model", "--truth", "--reference", "--extended", "--in"};
    if (of_files.count(word) == 0 || i + 1 == call.size() || !fs::exists(folder / call[i + 1])) return "";
  }
  for (std::size_t at = command.find(whole_case); at != std::string::npos;
       at = command.find(whole_case, at + toy.size()))
    command.replace(at, whole_case.size(), toy);
  return command;
}

/// A folder such as the reader of a page has.
class ReadersFolder {
public:
  ReadersFolder() {
    fs::create_directories(path() / "tests/cases");
    fs::copy(source_tree() / "cases", path() / "cases", fs::copy_options::recursive);
    fs::copy(source_tree() / toy, path() / toy, fs::copy_options::recursive);
    fs::create_directories(folder_ / "bin");
    fs::create_symlink(THERMOTWIN_PROGRAM, folder_ / "bin/thermotwin");
  }

  fs::path path() const { return folder_ / "reader"; }

  struct Ran {
    std::string failure;  ///< what the commands said where they failed
    std::string said;     ///< standard output, then what else they said
  };

  Ran run(const std::vector<std::string>& commands) const {
    const fs::path script = folder_ / "script.sh", out = folder_ / "out.txt", log = folder_ / "log.txt";
    std::ofstream text(script);
    text << "set -eo pipefail\n";
    for (const std::string& command : commands) text << command << "\n";
    text.close();
    const std::string bin = (folder_ / "bin").string(),
                      call = "cd '" + path().string() + "' && env -u DISPLAY -u THERMOTWIN_DATA PATH='" + bin +
                             "':\"$PATH\" timeout " + std::to_string(patience_s) + " bash '" + script.string() +
                             "' >'" + out.string() + "' 2>'" + log.string() + "' </dev/null";
    const bool failed = std::system(call.c_str()) != 0;
    const std::string said = read(out) + "\n" + read(log);
    if (!failed) return {"", said};
    constexpr std::size_t most = 2000;
    return {said == "\n" ? "it failed and said nothing" : said.substr(said.size() > most ? said.size() - most : 0),
            said};
  }

private:
  core::TemporaryFolder folder_;
};

std::vector<std::string> documentation_pages() {
  std::vector<std::string> pages;
  for (const fs::path& file : files_with(".md")) {
    if (file == "README.md" || file.begin()->string() == "docs") pages.push_back(file.string());
  }
  return pages;
}

/// Whether a command stands in a block that no test would find.
bool hides_commands(const CodeBlock& block) {
  if (block.info == "text" || block.info.starts_with("sh")) return false;
  return std::any_of(block.lines.begin(), block.lines.end(), [](const std::string& line) {
    return line.starts_with("thermotwin ") || line.starts_with("build/thermotwin ") || line.starts_with("tools/") ||
           line.starts_with("$ ");
  });
}

class Documentation : public testing::TestWithParam<std::string> {};

TEST_P(Documentation, CommandsWork) {
  std::optional<ReadersFolder> made;  // most pages run nothing
  const auto folder = [&]() -> const ReadersFolder& { return made ? *made : made.emplace(); };
  std::optional<std::string> said;  // by the block before
  for (const CodeBlock& block : code_blocks_of(read(source_tree() / GetParam()))) {
    const std::string place = GetParam() + ":" + std::to_string(block.line);
    EXPECT_FALSE(hides_commands(block)) << place << ": commands stand in blocks of ```sh, ```sh long or ```sh parse";
    if (block.info == "text" && said) {
      EXPECT_EQ(missing_in(block.lines, *said), "") << place << ", of\n" << *said;
    }
    said.reset();
    if (!block.info.starts_with("sh")) continue;
    EXPECT_TRUE(block.info == "sh" || block.info == "sh long" || block.info == "sh parse")
        << place << ": " << block.info;
    const std::vector<std::string> commands = commands_of(block);
    for (const std::string& command : commands) EXPECT_EQ(fault_of(command), "") << place << ": " << command;
    if (HasFailure()) continue;
    if (block.info == "sh") {
      ReadersFolder::Ran ran = folder().run(commands);
      EXPECT_EQ(ran.failure, "") << place;
      said = std::move(ran.said);
    } else if (block.info == "sh long") {
      for (const std::string& command : commands) {
        const std::string small = on_toy(command, made ? made->path() : source_tree());
        if (small.empty()) continue;
        EXPECT_EQ(folder().run({small}).failure, "") << place << ": " << small;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Pages, Documentation, testing::ValuesIn(documentation_pages()),
                         [](const testing::TestParamInfo<std::string>& page) {
                           std::string name = page.param.substr(0, page.param.rfind(".md"));
                           for (char& c : name)
                             if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
                           return name;
                         });

/// Files that blocks of a page write: cat > FILE <<'END' and cat >> FILE <<'END'.
std::map<std::string, std::string> files_of_page(const std::string& page) {
  std::map<std::string, std::string> files;
  for (const CodeBlock& block : code_blocks_of(read(source_tree() / page))) {
    std::string* open = nullptr;
    for (const std::string& line : block.lines) {
      const Words words = words_of(line);
      if (open != nullptr && line == "END") {
        open = nullptr;
      } else if (open != nullptr) {
        *open += line + "\n";
      } else if (line.ends_with("<<'END'") && words.size() > 2 && words[0] == "cat") {
        const std::string& name = words[2] == ">" ? words[3] : words[2];
        open = &files[name];
        if (words[2] != ">") open->clear();
      }
    }
  }
  return files;
}

TEST(Tutorial, TheMillOfTheCasesIsWhatItsPagesWrite) {
  std::map<std::string, std::string> written = files_of_page("docs/tutorials/own_machine.md");
  written.merge(files_of_page("docs/tutorials/own_machine_offsets.md"));
  EXPECT_EQ(written.size(), 8U);
  for (const auto& [name, text] : written) {
    ASSERT_TRUE(name.starts_with("mill/")) << name;
    const std::string licence = name.ends_with(".obj") ? "" : "# SPDX-License-Identifier: GPL-3.0-or-later\n";
    EXPECT_EQ(read(source_tree() / "cases" / name), licence + text) << name;
  }
}

/// The anchor that a heading gets on the web: small letters, digits, - and _, a blank becomes -.
std::string anchor_of(const std::string& heading) {
  const std::string words = std::regex_replace(heading, std::regex(R"(\[([^\]]*)\]\([^)]*\))"), "$1");
  std::string anchor;
  for (const char c : words.substr(words.find_first_not_of("# "))) {
    const auto byte = static_cast<unsigned char>(c);
    if (std::isalnum(byte) != 0 || c == '-' || c == '_' || byte >= 0x80) {
      anchor += static_cast<char>(std::tolower(byte));
    } else if (c == ' ') {
      anchor += '-';
    }
  }
  return anchor;
}

TEST(DocumentationLinks, LeadToFilesAndHeadings) {
  static const std::regex link(R"(\]\(([^)#\s]*)(?:#([^)\s]*))?\))");
  int found = 0;
  for (const fs::path& page : files_with(".md")) {
    for (const std::string& line : prose_lines(read(source_tree() / page))) {
      for (std::sregex_iterator at(line.begin(), line.end(), link); at != std::sregex_iterator(); ++at) {
        const std::string file = (*at)[1], anchor = (*at)[2];
        if (file.starts_with("http")) continue;
        ++found;
        const fs::path target = file.empty() ? page : (page.parent_path() / file).lexically_normal();
        const bool exists = fs::exists(source_tree() / target);
        EXPECT_TRUE(exists) << page << ": no " << target;
        if (anchor.empty() || target.extension() != ".md" || !exists) continue;
        const std::vector<std::string> lines = prose_lines(read(source_tree() / target));
        EXPECT_TRUE(std::any_of(
            lines.begin(), lines.end(),
            [&](const std::string& of_target) { return of_target.starts_with("#") && anchor_of(of_target) == anchor; }))
            << page << ": no heading #" << anchor << " in " << target;
      }
    }
  }
  EXPECT_GT(found, 400);
}

TEST(DocumentationLinks, TheMapNamesEveryPage) {
  const std::string map = read(source_tree() / "docs/README.md");
  for (const fs::path& page : files_with(".md")) {
    if (*page.begin() != "docs" || page == "docs/README.md") continue;
    EXPECT_NE(map.find("(" + page.lexically_relative("docs").string()), std::string::npos) << page;
  }
}

TEST(VerbReference, HasARowForEachOption) {
  const std::string page = read(source_tree() / "docs/reference/verbs.md");
  const auto section = [&](const std::string& heading) {
    const std::size_t begin = page.find("\n## " + heading + "\n");
    return begin == std::string::npos ? "" : page.substr(begin, page.find("\n## ", begin + 1) - begin);
  };
  const std::string common = section("Common options");
  ASSERT_FALSE(common.empty());
  for (const std::string& verb : verbs()) {
    const std::string own = section(verb);
    EXPECT_FALSE(own.empty()) << verb;
    EXPECT_NE(page.find("[`" + verb + "`](#" + verb + ")"), std::string::npos) << verb;
    for (const std::string& option : options_of(verb)) {
      if (!option.starts_with("--")) continue;
      EXPECT_TRUE((own + common).find("`" + option + "`") != std::string::npos) << verb << " " << option;
    }
  }
}

TEST(DocumentationReader, JoinsLinesAndFindsCalls) {
  const CodeBlock block{"sh", 1, {"# note", "thermotwin mesh cases/vmc5 \\", "  --size 2 | tee log", "", "ls"}};
  EXPECT_EQ(commands_of(block), (std::vector<std::string>{"thermotwin mesh cases/vmc5  --size 2 | tee log", "ls"}));
  EXPECT_EQ(calls_in("X=1 build/thermotwin mesh 'a b' && thermotwin run | cat"),
            (std::vector<Words>{{"mesh", "a b"}, {"run"}}));
}

TEST(DocumentationReader, FindsWhatAPageShowsInWhatACommandSaid) {
  const std::string said =
      "mesh  9 bodies; 1 s\nRMS 35.5 um -> 1.6 um (88 %, interval 85 to 89).\n| T1 | 7 | 96.7 | 94.4 |\n";
  EXPECT_EQ(missing_in({"mesh 9 bodies; 8 s"}, said), "");
  EXPECT_EQ(missing_in({"RMS 35.4 um ->", "1.61 um (88 %,", "...", "| T1 | ... | 94.4 |"}, said), "");
  EXPECT_EQ(missing_in({"...", "interval 84 to 89)."}, said), "");
  EXPECT_EQ(missing_in({"RMS 35.5 um -> 1.7 um (88 %,"}, said), "");
  EXPECT_EQ(missing_in({"RMS 35.5 um -> 1.71 um (88 %,"}, said), "after RMS 35.5 um ->: shown '1.71', said '1.6'");
  EXPECT_EQ(missing_in({"interval 81 to 89)."}, said), "after interval: shown '81', said '85'");
  EXPECT_EQ(missing_in({"mesh 9 pieces"}, said), "after mesh 9: shown 'pieces', said 'bodies;'");
  EXPECT_EQ(missing_in({"interval", "...", "mesh"}, said), "after: shown 'mesh', said 'nothing'");
}

TEST(DocumentationReader, RefusesWhatTheProgramDoesNotKnow) {
  EXPECT_EQ(fault_of("thermotwin mesh cases/vmc5 --size 2"), "");
  EXPECT_EQ(fault_of("thermotwin VERB --help"), "");
  EXPECT_EQ(fault_of("thermotwin offsets --in a.csv --chain 'V [w b X t]' --out -"), "");
  EXPECT_EQ(fault_of("thermotwin mash cases/vmc5"), "unknown verb 'mash'");
  EXPECT_EQ(fault_of("thermotwin mesh cases/vmc5 --sise=2"), "unknown option '--sise' of mesh");
  EXPECT_EQ(fault_of("cat cases/vmc5/nosuch.toml"), "no 'cases/vmc5/nosuch.toml' in the tree");
}

TEST(DocumentationReader, MakesTheAnchorsOfHeadings) {
  EXPECT_EQ(anchor_of("## Where a `[[film]]` sits, and [why](why.md)"), "where-a-film-sits-and-why");
  EXPECT_EQ(anchor_of("# M_1: 3 x 4"), "m_1-3-x-4");
  EXPECT_EQ(prose_lines("# A\n```sh\n# b\n```\nc\n"), (std::vector<std::string>{"# A", "c"}));
}

TEST(DocumentationReader, TakesTheToyWhereTheCommandNamesNoMore) {
  const fs::path here = source_tree();
  EXPECT_EQ(on_toy("thermotwin reduce cases/vmc5 --order 30", here), "thermotwin reduce tests/cases/toy --order 30");
  EXPECT_EQ(on_toy("thermotwin reduce cases/vmc5 --bound-pose X=0", here), "");
  EXPECT_EQ(on_toy("thermotwin evaluate cases/vmc5 --data nosuch", here), "");
  EXPECT_EQ(on_toy("thermotwin evaluate cases/vmc5 --data cases", here),
            "thermotwin evaluate tests/cases/toy --data cases");
  EXPECT_EQ(on_toy("thermotwin evaluate --data cases", here), "");
}

}  // namespace
}  // namespace thermotwin::cases
