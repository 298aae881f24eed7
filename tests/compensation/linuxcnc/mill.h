// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A LinuxCNC configuration that has links of its own, in a folder of the test.

#include <string>

#include "tests/compensation/scratch.h"

namespace thermotwin::compensation::test {

class Mill {
public:
  /// @param from, to  a text of the INI file and what replaces it
  explicit Mill(const std::string& from = "", const std::string& to = "") {
    std::string text =
        "# a mill\n[EMC]\nMACHINE = mill\n[NAMES]\n[TRAJ]\nLINEAR_UNITS = inch\nCOORDINATES = X Y Z\n"
        "[KINS]\nKINEMATICS = trivkins coordinates=XYYZ\nJOINTS = 4\n"
        "[HAL]\nHALFILE = mill.hal\nHALFILE = LIB:lib.hal with words\nHALFILE = more.tcl\nHALFILE = absent.hal\n"
        "[SIGNALS]\nSPEED = speed\n[AXIS_X]\nMAX_VELOCITY = 200\n[AXIS_Z]\nOFFSET_AV_RATIO = 0.1\n";
    if (const auto at = text.find(from); !from.empty() && at != std::string::npos) text.replace(at, from.size(), to);
    folder_.write("mill.ini", text);
    folder_.write("mill.hal",
                  "loadrt abs names=one,two\nnet X-here joint.0.pos-cmd => one.in # comment\n"
                  "net [SIGNALS](SPEED) spindle.0.speed-out-abs \\\n  => two.in\naddf motion-controller fast-thread\n"
                  "loadusr -Wn panel pyvcp -c panel panel.xml\n");
    folder_.write("lib/lib.hal", "newsig is-on bit\nlinkps motion.motion-enabled is-on\n");
    folder_.write("more.tcl", "net a b\n");
  }
  std::filesystem::path ini() const { return folder_.path() / "mill.ini"; }
  std::filesystem::path library() const { return folder_.path() / "lib"; }
  void write(const std::string& name, const std::string& text) { folder_.write(name, text); }

private:
  Scratch folder_;
};

}  // namespace thermotwin::compensation::test
