#pragma once
// What a command is at, on standard error.

#include <chrono>
#include <string>

namespace tiltfeed {

/// On a terminal one line, rewritten in place; elsewhere one a stage.
class ProgressLine {
 public:
  /// False: the user wants it to end.
  bool show(const std::string& text, double fraction);
  /// A line of its own, which stays.
  void note(const std::string& text);
  ~ProgressLine();
  ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

 private:
  const bool terminal_;
  std::string text_;
  std::chrono::steady_clock::time_point shown_;
};

}  // namespace tiltfeed
