// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/dialect/siemens_words.h"

#include <algorithm>
#include <iterator>
#include <set>

namespace thermotwin::nc {

bool is_skipped_keyword(const std::string& name) {
  static const std::set<std::string, std::less<>> names{
      "STOPRE",   "MSG",      "FFWON",      "FFWOF",       "SOFT",      "BRISK",   "DRIVE",    "COMPOF",    "COMPON",
      "COMPCURV", "COMPCAD",  "COMPSURF",   "UPATH",       "SPATH",     "FNORM",   "ORIAXES",  "ORIMKS",    "ORIWKS",
      "OSOF",     "RTLION",   "RTLIOF",     "CFC",         "CFTCP",     "CFIN",    "KONT",     "NORM",      "WALIMON",
      "WALIMOF",  "LFON",     "LFOF",       "SPCON",       "SPCOF",     "SPOS",    "SPOSA",    "DIAMOF",    "DYNNORM",
      "DYNPOS",   "DYNROUGH", "DYNSEMIFIN", "DYNFINISH",   "DYNPREC",   "ADISPOS", "FIFOCTRL", "STARTFIFO", "PREPRO",
      "SETMS",    "CYCLE832", "WORKPIECE",  "GROUP_BEGIN", "GROUP_END", "LIMS",    "CDOF",     "CDON",
  };
  return names.count(name) > 0;
}

bool is_same_word(int number) {
  static const std::set<int> numbers{0, 1, 2, 3, 17, 18, 19, 33, 40, 41, 42, 93, 94, 95, 97};
  return numbers.count(number) > 0;
}

bool is_skipped_word(int number) {
  static const std::set<int> numbers{62, 290, 450, 451, 460, 461, 462, 601, 602, 603, 621};
  return numbers.count(number) > 0;
}

bool is_frame(const std::string& name) {
  static const std::set<std::string, std::less<>> frames{"TRANS", "ATRANS", "ROT",    "AROT",   "ROTS",
                                                         "AROTS", "SCALE",  "ASCALE", "MIRROR", "AMIRROR"};
  return frames.count(name) > 0;
}

bool is_control_statement(const std::string& word) {
  static constexpr const char* control[] = {"IF",    "ELSE",    "ENDIF",  "WHILE",   "ENDWHILE", "FOR",  "ENDFOR",
                                            "LOOP",  "ENDLOOP", "REPEAT", "REPEATB", "UNTIL",    "GOTO", "GOTOF",
                                            "GOTOB", "GOTOC",   "GOTOS",  "CASE",    "PROC",     "CALL", "MCALL",
                                            "PCALL", "EXTCALL", "RET",    "DEF"};
  return std::find(std::begin(control), std::end(control), word) != std::end(control);
}

}  // namespace thermotwin::nc
