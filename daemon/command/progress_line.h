#pragma once
// What a command is at, on standard error.

#include <chrono>
#include <string>
#include <vector>

#include "config/output_file.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

/// The file of `--progress`, opened; -1 for an empty name. It is made, or holds progress: nothing else is
/// written over. Errors: kUsage (another file is there, or one of `outputs` is the same), kIo.
Result<int> open_progress(const std::string& file, std::vector<config::NamedFile> outputs);

/// On a terminal one line, rewritten in place; elsewhere one a stage.
class ProgressLine {
 public:
  /// False: the user wants it to end.
  bool show(const std::string& text, double fraction);
  /// A line of its own, which stays.
  void note(const std::string& text);
  ~ProgressLine();
  /// `file`: holds the newest stage and percentage, too, in a line of its own; it is closed here. -1: none.
  explicit ProgressLine(int file = -1);
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

 private:
  void write_file_line(const std::string& text, double fraction) const;

  const bool terminal_;
  const int file_;
  std::string text_;
  std::chrono::steady_clock::time_point shown_;
};

}  // namespace tiltfeed::daemon
