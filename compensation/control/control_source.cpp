// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/control/control_source.h"

#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <set>
#include <utility>

#include "compensation/control/twin.h"
#include "core/character.h"
#include "core/file.h"

namespace thermotwin::compensation {
namespace {

constexpr const char* licence = "/* SPDX-License-Identifier: GPL-3.0-or-later */\n";

template <class... Values>
void put(fmt::memory_buffer& out, fmt::format_string<Values...> format, Values&&... values) {
  fmt::format_to(std::back_inserter(out), format, std::forward<Values>(values)...);
}

void append(fmt::memory_buffer& out, double value) {
  if (std::isnan(value))
    put(out, "NAN");
  else if (std::isinf(value))
    put(out, "{}", value > 0.0 ? "INFINITY" : "-INFINITY");
  else if (value == std::floor(value) && std::abs(value) < 1e6 && !std::signbit(value))
    put(out, "{}.0", static_cast<long>(value));
  else
    put(out, "{:a}", value);
}
void append(fmt::memory_buffer& out, std::int32_t value) { put(out, "{}", value); }
void append(fmt::memory_buffer& out, const std::string& value) { put(out, "{}", c_literal(value)); }

/// static const TYPE name[] = {...};  an empty array has one element that nothing reads
template <class Value>
void append_array(fmt::memory_buffer& out, const char* type, const char* name, const std::vector<Value>& values) {
  constexpr std::size_t longest_line = 116;
  put(out, "static const {} {}[] = {{\n", type, name);
  std::size_t line = out.size();
  for (const Value& value : values) {
    append(out, value);
    put(out, ",");
    if (out.size() - line < longest_line - 28) continue;
    out.push_back('\n');
    line = out.size();
  }
  put(out, "{}}};\n", values.empty() ? "0" : "");
}

/// "axis.X.position_mm" as AXIS_X_POSITION_MM
std::string constant_name(const std::string& channel) {
  std::string name;
  for (const char c : channel) name += core::is_letter_or_digit(c) ? core::upper(c) : '_';
  return name;
}

}  // namespace

std::string comment_text(const std::string& text) {
  std::string result;
  for (char c : text) {
    if ((c >= 0 && c < ' ') || c == '\x7f') c = ' ';
    if (c == '\\') c = '|';  // no line that goes on
    // No "*/" and no "/*".
    const bool ends = (c == '/' || c == '*') && !result.empty() && (result.back() == '*' || result.back() == '/');
    if (ends) result += ' ';
    result += c;
  }
  return result;
}

std::string c_literal(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c < ' ' || c > '~' || c == '"' || c == '\\' || c == '?')  // ? begins trigraphs
      result += fmt::format("\\{:03o}", c & 0xFF);
    else
      result += c;
  }
  return result + "\"";
}

std::string flat_includes(const std::string& text) {
  const std::string folder = "#include \"compensation/control/";
  std::string flat = text;
  for (std::size_t at = flat.find(folder); at != std::string::npos; at = flat.find(folder, at))
    flat.replace(at, folder.size(), "#include \"");
  return flat;
}

std::string model_source(const ControlData& data) {
  fmt::memory_buffer out;
  put(out, "{}", licence);
  put(out, "/* The reduced model of {}. */\n#include \"model_data.h\"\n\n#include <math.h>\n\n",
      comment_text(data.name));
#define TT_FIELD(x) append_array(out, "double", #x, data.x);
  TT_MODEL_DOUBLES(TT_FIELD)
#undef TT_FIELD
#define TT_FIELD(x) append_array(out, "int32_t", #x, data.x);
  TT_MODEL_INTS(TT_FIELD)
#undef TT_FIELD
#define TT_FIELD(x) append_array(out, "char* const", #x, data.x);
  TT_MODEL_TEXTS(TT_FIELD)
#undef TT_FIELD
  put(out, "\nconst tt_model tt_the_model = {{\n  {}, UINT64_C(0x{:016X}),\n", c_literal(data.name), data.hash);
#define TT_FIELD(x) put(out, "  {}, /* {} */\n", data.x, #x);
  TT_MODEL_COUNTS(TT_FIELD)
#undef TT_FIELD
#define TT_FIELD(x)    \
  put(out, "  ");      \
  append(out, data.x); \
  put(out, ", /* {} */\n", #x);
  TT_MODEL_NUMBERS(TT_FIELD)
#undef TT_FIELD
#define TT_FIELD(x) put(out, "  {},\n", #x);
  TT_MODEL_DOUBLES(TT_FIELD)
  TT_MODEL_INTS(TT_FIELD)
  TT_MODEL_TEXTS(TT_FIELD)
#undef TT_FIELD
  put(out, "}};\n");
  return fmt::to_string(out);
}

std::string model_header(const ControlData& data, const tt_model& model) {
  fmt::memory_buffer out;
  put(out, "{}#ifndef THERMOTWIN_MODEL_DATA_H\n#define THERMOTWIN_MODEL_DATA_H\n", licence);
  put(out, "/* The reduced model of {}, and the memory that a twin of it needs. */\n\n#include \"model.h\"\n\n",
      comment_text(data.name));
  put(out, "#ifdef __cplusplus\nextern \"C\" {{\n#endif\n\nextern const tt_model tt_the_model;\n\n");
  put(out,
      "enum {{\n  TT_STATE_BYTES = {},\n  TT_WORK_BYTES = {},\n  TT_CHANNELS = {},\n  TT_SENSORS = {},\n  "
      "TT_LINEAR_AXES = {}\n}};\n\n",
      tt_twin_state_bytes(&model), tt_twin_work_bytes(&model), data.channels, data.sensors, data.linear_axes);
  put(out, "/* Channels of a row, in the units of their names. */\nenum {{\n");
  std::set<std::string> taken;
  for (std::size_t k = 0; k < data.channel_names.size(); ++k) {
    std::string name = constant_name(data.channel_names[k]);
    if (!taken.insert(name).second) taken.insert(name += fmt::format("_{}", k));  // "a-b" beside "a_b"
    put(out, "  TT_CHANNEL_{} = {}{}\n", name, k, k + 1 < data.channel_names.size() ? "," : "");
  }
  put(out, "}};\n\n#ifdef __cplusplus\n}}\n#endif\n#endif\n");
  return fmt::to_string(out);
}

std::vector<std::string> write_control_source(const std::filesystem::path& folder, const ControlData& data,
                                              const tt_model& model) {
  std::vector<std::string> names;
  const auto write = [&](const std::string& name, const std::string& text) {
    core::write_file(folder / name, text);
    names.push_back(name);
  };
  for (const EmbeddedFile& file : control_files()) {
    const std::string name = file.name;
    if (!name.starts_with("fm") && !name.starts_with("model_bytes")) write(name, flat_includes(file.text));
  }
  write("model_data.h", model_header(data, model));
  write("model_data.c", model_source(data));
  return names;
}

}  // namespace thermotwin::compensation
