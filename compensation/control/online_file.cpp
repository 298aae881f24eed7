// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/control/online_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <elf.h>
#include <fstream>
#include <link.h>
#include <optional>
#include <sys/stat.h>
#include <system_error>
#include <utility>
#include <vector>

#include "compensation/control/model_order.h"
#include "core/error.h"
#include "core/file.h"
#include "core/progress.h"
#include "reduction/linear/store_trailer.h"
#include "reduction/model/model_file.h"

namespace thermotwin::compensation {
namespace {

namespace fs = std::filesystem;
using Stamp = std::array<std::int64_t, 4>;

constexpr std::int64_t second_ns = 1000000000;
/// Times of a file system have steps of some ms; of one that has whole seconds only, up to 2 s.
constexpr std::int64_t settled_ns = second_ns / 10, coarsely_settled_ns = 3 * second_ns;

/// The notes of one part of the program in memory. @return the linker's hash of the program, in hexadecimal digits
std::string build_id_in(const char* notes, std::size_t size) {
  constexpr auto padded = [](std::size_t bytes) { return (bytes + 3) / 4 * 4; };
  for (std::size_t at = 0; at + sizeof(ElfW(Nhdr)) <= size;) {
    ElfW(Nhdr) note;
    std::memcpy(&note, notes + at, sizeof note);
    const std::size_t name = at + sizeof note, value = name + padded(note.n_namesz),
                      next = value + padded(note.n_descsz);
    if (next > size) break;
    if (note.n_type == NT_GNU_BUILD_ID && note.n_namesz == 4 && std::memcmp(notes + name, "GNU", 4) == 0) {
      std::string digits;
      for (std::size_t i = 0; i < note.n_descsz; ++i) digits += fmt::format("{:02x}", notes[value + i] & 0xFF);
      return digits;
    }
    at = next;
  }
  return "";
}

/// Of the running program; empty: its linker made none.
std::string build_id() {
  static std::string id;
  dl_iterate_phdr(
      [](dl_phdr_info* object, std::size_t, void*) {
        for (int i = 0; i < object->dlpi_phnum; ++i) {
          const ElfW(Phdr)& part = object->dlpi_phdr[i];
          if (part.p_type != PT_NOTE) continue;
          const auto* notes = reinterpret_cast<const char*>(object->dlpi_addr + part.p_vaddr);
          if (std::string here = build_id_in(notes, part.p_memsz); !here.empty()) id = std::move(here);
        }
        return 1;  // the first object is the program
      },
      nullptr);
  return id;
}

std::string stem_of(const fs::path& model) {
  const std::string name = model.filename().string(), ending = ".rom.h5";
  return name.ends_with(ending) && name.size() > ending.size() ? name.substr(0, name.size() - ending.size())
                                                               : model.stem().string();
}

/// Where the file may lie, the first choice first.
std::vector<fs::path> places_of(const OnlineSource& source) {
  std::vector<fs::path> places = {online_file(source)};
  if (!source.state.empty()) {
    fs::path beside_state = source.state.parent_path() / places.front().filename();
    std::error_code none;
    if (!fs::equivalent(beside_state.parent_path().empty() ? "." : beside_state.parent_path(),
                        places.front().parent_path().empty() ? "." : places.front().parent_path(), none))
      places.push_back(std::move(beside_state));
  }
  return places;
}

/// What a file has to say of the model as it is now.
OnlineKey key_of(const OnlineSource& source) {
  return {build_id(), reduction::read_store_trailer(source.model), file_stamp(source.model), source.order};
}

/// Data that hold for the model; where that has another stamp than it had, `checked` becomes true.
/// @return nothing where the file is to be written anew, or the model has to be read to say what is wrong with it
std::optional<OnlineData> believed(const fs::path& file, const fs::path& model, const OnlineKey& now, bool& checked) {
  std::ifstream in(file, std::ios::binary);
  if (!in) return std::nullopt;
  try {
    OnlineReader reader(in, file.string());
    const OnlineKey& key = reader.key();
    const char* other = key.program != now.program         ? "another build of the program"
                        : key.model_line != now.model_line ? "another model"
                        : key.order != now.order           ? "another order"
                                                           : nullptr;
    if (other != nullptr) {
      core::log_line(fmt::format("{}: online data of {}, not used", file.string(), other));
      return std::nullopt;
    }
    checked = key.model_stamp != now.model_stamp || now.model_stamp == Stamp{};
    if (checked && !reduction::store_file_holds(model)) return std::nullopt;
    return reader.read(model);
  } catch (const core::InputError& error) {
    core::warn(fmt::format("{}; not used", error.what()));
    return std::nullopt;
  }
}

void write(const std::vector<fs::path>& places, const OnlineKey& key, const OnlineData& data, bool say) {
  const std::string bytes = online_bytes(key, data);
  std::string why;
  for (const fs::path& file : places) {
    try {
      core::write_file(file, bytes);
      if (say) core::log_line(fmt::format("online data written to {}, from which the next start reads", file.string()));
      return;
    } catch (const core::InputError& error) {
      why += (why.empty() ? "" : "; ") + std::string(error.what());
    }
  }
  if (say) core::log_line(fmt::format("online data are not kept, each start reads the whole model: {}", why));
}

}  // namespace

fs::path online_file(const OnlineSource& source) {
  const std::string order = source.order > 0 ? fmt::format(".order{}", source.order) : "";
  return source.model.parent_path() / (stem_of(source.model) + order + ".online");
}

Stamp file_stamp(const fs::path& file) {
  struct stat found {};
  if (::stat(file.c_str(), &found) != 0) return {};
  const auto ns = [](const timespec& time) { return time.tv_sec * second_ns + time.tv_nsec; };
  const std::int64_t content = ns(found.st_mtim), anything = ns(found.st_ctim);
  const std::int64_t now = std::chrono::nanoseconds(std::chrono::system_clock::now().time_since_epoch()).count();
  const bool coarse = content % second_ns == 0 && anything % second_ns == 0;
  if (now - std::max(content, anything) < (coarse ? coarsely_settled_ns : settled_ns)) return {};
  const std::int64_t size = found.st_size, number = found.st_ino;
  return {size, number, content, anything};
}

OnlineData online_data(const OnlineSource& source) {
  const OnlineKey now = key_of(source);
  const std::vector<fs::path> places = places_of(source);
  const bool can_be_known = !now.program.empty() && !now.model_line.empty();
  for (std::size_t i = 0; can_be_known && i < places.size(); ++i) {
    bool checked = false;
    if (auto data = believed(places[i], source.model, now, checked)) {
      if (checked && now.model_stamp != Stamp{}) write({places[i]}, now, *data, false);
      return std::move(*data);
    }
  }
  OnlineData data{model_of_order(reduction::read_model(source.model), source.order), {}};
  data.derived = derived_data(data.model, ControlOptions().tolerance);
  keep_online(data.model);
  // Not where the model was replaced meanwhile.
  if (can_be_known && can_be_stored(data) && now.model_line == reduction::read_store_trailer(source.model))
    write(places, now, data, true);
  return data;
}

}  // namespace thermotwin::compensation
