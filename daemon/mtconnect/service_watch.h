#pragma once
// Asks a service what is on its machine, as any client does.

#include <cstdint>
#include <fstream>
#include <optional>
#include <string>

#include "daemon/mtconnect/observations.h"

namespace tiltfeed::daemon {

/// One line of a program after the other, without keeping the program.
class ProgramLine {
 public:
  /// Line `number` (from 1) of the file; empty where it cannot be had. Going on is quick, going back reads
  /// the file again.
  std::string read(const std::string& path, std::uint64_t number);

 private:
  std::string path_, line_;
  std::ifstream in_;
  std::uint64_t at_ = 0;
};

/// Of one service. look() waits for its answers, so it has a thread of its own.
class ServiceWatch {
 public:
  explicit ServiceWatch(std::string socket) : socket_(std::move(socket)) {}

  /// Nothing where the service does not answer.
  std::optional<ServiceView> look();
  /// A job is on the machine, as far as the last look told.
  bool runs() const { return job_ != 0; }

 private:
  bool find_job();
  bool show_job(ServiceView& view);
  bool read_history();

  std::string socket_;
  std::uint64_t job_ = 0;  // on the machine; 0: none
  std::uint64_t run_ = 0;  // newest run of the history that has ended
  std::uint64_t parts_ = 0;
  std::string last_;  // that run
  ProgramLine program_;
};

}  // namespace tiltfeed::daemon
