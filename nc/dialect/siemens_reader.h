// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Programs of Sinumerik controls for LinuxCNC's interpreter, line by line: motion (G0 to G3, CR, TURN, AC, IC, DC, ACP,
// ACN, R parameters), dwells, planes, frames by TRANS, ATRANS and G54 to G59.2 (G505 to G508), tools, spindle, fluid,
// TRAORI and TRAFOOF. G70 and G71 are the unit of lengths, G700 and G710 that of F as well; F is else in mm, as the
// basic system is metric. DC, ACP and ACN count from where the axis is, at first from the start position. A statement
// that is neither known nor in the control profile is refused with its line: jumps, loops, cycles, subprograms, ROT,
// SCALE, MIRROR, tool vectors, splines, polar coordinates.

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "nc/control/control_profile.h"
#include "nc/dialect/siemens_line.h"
#include "nc/dialect/siemens_places.h"
#include "nc/dialect/siemens_value.h"

namespace thermotwin::nc {

class SiemensReader {
public:
  /// @param control  words and tools; must outlive the reader
  /// @param axis_mask  letters of the machine's axes, bit 0: X
  /// @param name  of the program, for messages  @param start  of the axes before the program, m and rad
  SiemensReader(const ControlProfile& control, int axis_mask, std::string name, const Nine& start = Nine::Zero());

  /// @return the line as LinuxCNC's interpreter reads it, without an end; may be empty
  /// @throws InputError (file:line)
  std::string translate(std::string_view line, std::size_t number);

private:
  /// What a line adds up to before it is written.
  struct Block {
    std::vector<std::string> words;
    SiemensCoordinates axes;
    std::array<std::optional<SiemensValue>, 3> centre;
    bool dwell = false, machine = false, path_mode = false, tool_change = false, tool = false, edge = false;
    std::string tcp;  ///< marker
    std::optional<double> feed;
    std::size_t feed_at = 0;  ///< its place among the words
    bool unit = false;        ///< G70, G71, G700, G710
  };

  void statement(const SiemensStatement& statement, Block& block);
  bool by_profile(const SiemensStatement& statement, Block& block) const;
  void g_word(const SiemensStatement& statement, Block& block);
  bool frame_g(int number, Block& block);
  bool path_g(int number, Block& block);
  void m_word(const SiemensStatement& statement, Block& block) const;
  void letter(const SiemensStatement& statement, Block& block);
  void keyword(const SiemensStatement& statement, Block& block);
  void tool(const SiemensStatement& statement, Block& block);
  std::string frame(const std::vector<SiemensStatement>& statements);
  std::string written(Block& block);
  void unit_g(int number, Block& block);
  void add_feed(Block& block);
  void add_centre(const Block& block, std::string& text);
  void add_tool_length(const Block& block, std::string& text);
  std::string path_mode() const;
  SiemensValue value(const SiemensStatement& statement) const;
  double plain(const SiemensStatement& statement) const;
  long whole(const SiemensStatement& statement) const;
  [[noreturn]] void refuse(const SiemensStatement& statement, const std::string& allowed) const;
  [[noreturn]] void refuse_unknown(const SiemensStatement& statement) const;

  const ControlProfile& control_;
  int mask_;
  std::string name_, place_;
  SiemensParameters parameters_;
  SiemensPlaces places_;
  bool feed_in_inch_ = false, inverse_time_ = false;
  bool inch_before_ = false;  ///< before the present line
  bool centre_absolute_ = false, inch_ = false;
  bool edge_ = true, tool_in_ = false, next_tool_ = false;  ///< D1; a tool in the spindle; one is called
  int path_ = 0;      ///< 0 as the control starts, 60 exact stop, 64, 641 with adis_
  double adis_ = 0;   ///< program units
  double speed_ = 0;  ///< rpm
  bool exact_stop_once_ = false;
};

}  // namespace thermotwin::nc
