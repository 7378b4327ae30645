#pragma once
// The lines of a program around one of them, from a file of any length.

#include <cstdint>
#include <string>
#include <vector>

#include "kinematics/basics/result.h"

namespace tiltfeed::desk {

/// Properties: a call reads kSlice at most, so that nothing waits for a long file; holds one place of the
/// file for kStep lines.
class ProgramText {
 public:
  static constexpr std::size_t kSlice = 4u << 20;
  static constexpr std::uint64_t kStep = 256;
  /// A longer line is cut off there, bytes.
  static constexpr std::size_t kMaxLine = 160;

  /// Errors: kIo: not a file that may be read.
  static Result<ProgramText> open(const std::string& path);
  ProgramText(ProgramText&& other) noexcept;
  ProgramText& operator=(ProgramText&& other) noexcept;
  ~ProgramText();

  /// Reads on; true: there is more to read.
  bool read_on();
  /// Lines from `first` (counted from 1), `count` at most, as far as the file has been read.
  std::vector<std::string> lines(std::uint64_t first, std::uint64_t count) const;

 private:
  explicit ProgramText(int fd) : fd_(fd) {}
  int fd_ = -1;
  std::uint64_t read_ = 0, line_ = 0;     // so far: bytes; ends of lines in them
  std::vector<std::uint64_t> starts_{0};  // of lines 1, 1 + kStep, ...
  bool whole_ = false;
};

}  // namespace tiltfeed::desk
