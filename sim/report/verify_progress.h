#pragma once
// What `verify` is at: a line on standard error, rewritten in place, where that is a terminal; a line in a
// file for a program that follows.

#include <chrono>
#include <string>

namespace tiltfeed::sim {

class VerifyProgress {
 public:
  /// `file`: empty: none. One that cannot be written is no reason to stop.
  explicit VerifyProgress(const std::string& file);
  VerifyProgress(const VerifyProgress&) = delete;
  VerifyProgress& operator=(const VerifyProgress&) = delete;
  ~VerifyProgress();

  void show(const std::string& stage, double share);

 private:
  const bool terminal_;
  int file_ = -1;
  std::string stage_;
  std::chrono::steady_clock::time_point shown_;
};

}  // namespace tiltfeed::sim
