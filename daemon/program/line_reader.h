#pragma once
// The program file, read line by line through a bounded window, reduced to what may go onto a wire.

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "daemon/files/program_file.h"
#include "daemon/program/line.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

/// What one pass over the whole file found.
struct ProgramFacts {
  std::uint64_t lines = 0;              ///< lines to send
  std::uint64_t waits = 0;              ///< of these, M0 M1 M6
  std::uint64_t bytes = 0;              ///< of these, LF included
  std::size_t longest = 0;              ///< bytes of the longest of these, without LF
  std::uint64_t longest_line = 0;       ///< its number
  std::string header;                   ///< text of the first comment that starts with TILTFEED
  std::array<std::uint8_t, 32> hash{};  ///< SHA-256 of the whole file
};

/// Properties: memory does not depend on the file's length but for 32 bytes a 64 KiB of it; after survey()
/// every pass gives the lines that the survey saw, or an error.
class LineReader {
 public:
  /// Errors: kIo; kInput when it is not a regular file (it is read twice).
  static Result<LineReader> open(const std::string& path);

  /// Reads the next line to send into `line`; false at the end: the file's end, M2 or M30 (which is sent,
  /// what follows is not), or the second %. Errors: kIo, or kInput with path:line: a live byte (! ~ ? 0x18,
  /// 0x80 and above), $ or / outside a comment, an open comment, a line longer than kMaxLine, a byte between
  /// two words that is a line's end elsewhere (VT, FF, FS, GS, RS), a name with brackets or one that only a
  /// blank parts from the next (Sinumerik, Heidenhain).
  Result<bool> next(Line& line);
  /// The next line as it stands in the file, comments and all, without its end; false at the file's end. Its
  /// number is number(). For who reads comments: not mixed with `next`. Errors: kIo; kInput: too long.
  Result<bool> read_raw(std::string_view& raw);
  std::uint64_t number() const { return number_; }
  /// Back to the first line. Errors: kIo.
  Result<void> rewind();
  /// Reads the whole file, then rewinds. Errors: as `next`; kInput when there is nothing to send.
  Result<ProgramFacts> survey();
  const std::string& path() const { return path_; }

 private:
  explicit LineReader(ProgramFile file) : file_(std::move(file)) {}

  Result<void> clean(std::string_view raw, std::string& text);
  tl::unexpected<Error> bad_line(const std::string& what) const;

  std::string path_;
  ProgramFile file_;
  std::unique_ptr<char[]> window_;       // room for a line that has not ended, and a piece of the file
  std::size_t begin_ = 0, end_ = 0;      // unread part of the window
  std::uint64_t number_ = 0, sent_ = 0;  // lines read, lines given out
  bool at_end_ = false, finished_ = false;
  bool after_cr_ = false;  // an LF that comes now is the second half of the end before
  std::string header_;
};

}  // namespace tiltfeed::daemon
