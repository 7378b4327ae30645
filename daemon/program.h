#pragma once
// The program file, read line by line through a bounded window, reduced to what may go onto a wire.

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "kinematics/result.h"

namespace tiltfeed {

/// Longest line of any controller that is known (grblHAL 256), bytes without line end.
inline constexpr std::size_t kMaxLine = 256;
/// Longest line of the file itself, comments included: the reading window.
inline constexpr std::size_t kMaxRawLine = 65536;

/// One line as it is sent: upper case, printable ASCII, no blanks, no comments, never empty.
struct Line {
  std::uint64_t number = 0;  ///< 1-based in the file
  std::string text;
  bool alone = false;  ///< nothing else may be on its way with it: M0 M1 M6, G10 G28.1 G30.1
  bool waits = false;  ///< of these, M0 M1 M6: answered when the operator has acted
  double dwell = 0.0;  ///< seconds that G4 asks for
};

/// What one pass over the whole file found.
struct ProgramFacts {
  std::uint64_t lines = 0;         ///< lines to send
  std::uint64_t bytes = 0;         ///< of these, LF included
  std::size_t longest = 0;         ///< bytes of the longest of these, without LF
  std::uint64_t longest_line = 0;  ///< its number
  std::string header;              ///< text of the first comment that starts with TILTFEED
};

/// Properties: memory does not depend on the file's length; the same file gives the same lines on every pass.
class Program {
 public:
  /// Errors: kIo; kInput when it is not a regular file (it is read twice).
  static Result<Program> open(const std::string& path);

  /// Reads the next line to send into `line`; false at the end: the file's end, M2 or M30 (which is sent,
  /// what follows is not), or the second %. Errors: kIo, or kInput with path:line: a live byte (! ~ ? 0x18,
  /// 0x80 and above), $ or / outside a comment, an open comment, a line longer than kMaxLine.
  Result<bool> next(Line& line);
  /// Back to the first line. Errors: kIo, also when the file has changed since `open`.
  Result<void> rewind();
  /// Reads the whole file, then rewinds. Errors: as `next`; kInput when there is nothing to send.
  Result<ProgramFacts> survey();
  const std::string& path() const { return path_; }

 private:
  struct File;  // the descriptor and what the file looked like at `open`
  struct CloseFile {
    void operator()(File* file) const;
  };

  Result<bool> read_raw(std::string_view& raw);
  Result<void> clean(std::string_view raw, std::string& text);
  Result<void> check_unchanged() const;
  tl::unexpected<Error> bad_line(const std::string& what) const;

  std::string path_;
  std::unique_ptr<File, CloseFile> file_;
  std::unique_ptr<char[]> window_;       // kMaxRawLine bytes
  std::size_t begin_ = 0, end_ = 0;      // unread part of the window
  std::uint64_t number_ = 0, sent_ = 0;  // lines read, lines given out
  bool at_end_ = false, finished_ = false;
  std::string header_;
};

}  // namespace tiltfeed
