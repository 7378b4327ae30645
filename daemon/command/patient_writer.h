#pragma once
// Lines for a terminal or a pipe that may take none for a while (Ctrl-S, a connection that hangs, a full
// pipe): whoever has a machine to feed never waits for it.

#include <memory>
#include <string>

namespace tiltfeed::daemon {

class PatientWriter {
 public:
  explicit PatientWriter(int descriptor);
  /// Waits a moment for what is left, and no longer.
  ~PatientWriter();
  PatientWriter(const PatientWriter&) = delete;
  PatientWriter& operator=(const PatientWriter&) = delete;

  /// Returns at once. `newest`: what has not left yet is not worth writing any more; nor is what is older
  /// than the last 64.
  void write(std::string text, bool newest);
  /// It takes nothing any more: the terminal was closed, nobody reads the pipe.
  bool failed() const;

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;
};

}  // namespace tiltfeed::daemon
