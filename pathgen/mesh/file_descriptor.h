#pragma once
// Files by descriptor.

#include <string>

#include "kinematics/basics/result.h"

namespace tiltfeed::pathgen {

/// Closes on every way out.
class FileDescriptor {
 public:
  explicit FileDescriptor(int fd) : fd_(fd) {}
  ~FileDescriptor();
  FileDescriptor(const FileDescriptor&) = delete;
  FileDescriptor& operator=(const FileDescriptor&) = delete;
  int get() const { return fd_; }
  /// False when the close reports a write error.
  bool close();

 private:
  int fd_;
};

/// What errno says of the file.
tl::unexpected<Error> io_error(const std::string& path, const std::string& what);

}  // namespace tiltfeed::pathgen
