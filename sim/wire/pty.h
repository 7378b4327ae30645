#pragma once
// A pseudo-terminal in raw mode that stands in for a serial port, under a name of the user's choice.

#include <string>
#include <utility>

#include "kinematics/basics/result.h"

namespace tiltfeed::sim {

/// Keeps the slave side open itself, so that a host may close and open it again; removes its name at the end.
class Pty {
 public:
  /// `path` becomes a symbolic link to the slave. Errors: kIo; a `path` that exists and is no symbolic link
  /// is left alone.
  static Result<Pty> open(const std::string& path);

  Pty(Pty&& other) noexcept
      : master_(std::exchange(other.master_, -1)),
        slave_(std::exchange(other.slave_, -1)),
        path_(std::exchange(other.path_, {})),
        device_(std::move(other.device_)) {}
  Pty(const Pty&) = delete;
  Pty& operator=(const Pty&) = delete;
  Pty& operator=(Pty&&) = delete;
  ~Pty();

  int master() const { return master_; }
  /// As TcpPort has them: a terminal is always there.
  static bool welcome() { return false; }
  static void part() {}
  static bool connected() { return true; }
  const std::string& device() const { return device_; }  ///< the slave's own name

 private:
  Pty() = default;
  int master_ = -1, slave_ = -1;
  std::string path_, device_;
};

}  // namespace tiltfeed::sim
