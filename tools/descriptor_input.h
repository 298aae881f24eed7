// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Standard input as a stream buffer that ends when the user asks to stop: std::cin would go on
// waiting for the next row, since the library repeats a read that a signal broke off.

#include <array>
#include <streambuf>

namespace thermotwin::tools {

class DescriptorInput : public std::streambuf {
public:
  /// @param descriptor  open for reading; stays open
  explicit DescriptorInput(int descriptor) : descriptor_(descriptor) {}

protected:
  /// @throws core::Interrupted, which an istream takes for a bad stream
  int_type underflow() override;

private:
  int descriptor_;
  std::array<char, 65536> buffer_{};
};

}  // namespace thermotwin::tools
