#pragma once
// What a command is at, on standard error.

#include <chrono>
#include <string>

namespace tiltfeed::daemon {

/// On a terminal one line, rewritten in place; elsewhere one a stage.
class ProgressLine {
 public:
  /// False: the user wants it to end.
  bool show(const std::string& text, double fraction);
  /// A line of its own, which stays.
  void note(const std::string& text);
  ~ProgressLine();
  /// `file`: holds the newest stage and percentage, too, in a line of its own; empty: none.
  explicit ProgressLine(const std::string& file = {});
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

 private:
  void write_file_line(const std::string& text, double fraction) const;

  const bool terminal_;
  int file_ = -1;
  std::string text_;
  std::chrono::steady_clock::time_point shown_;
};

}  // namespace tiltfeed::daemon
