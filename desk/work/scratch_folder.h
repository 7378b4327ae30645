#pragma once
// A folder for what a desk works on, gone when it ends.

#include <string>

#include "kinematics/basics/result.h"

namespace tiltfeed::desk {

class ScratchFolder {
 public:
  /// Beneath $TMPDIR or /tmp, for this user alone. Errors: kIo.
  static Result<ScratchFolder> make();
  ScratchFolder(ScratchFolder&& other) noexcept;
  ScratchFolder& operator=(ScratchFolder&&) = delete;
  ~ScratchFolder();

  const std::string& path() const { return path_; }

 private:
  explicit ScratchFolder(std::string path) : path_(std::move(path)) {}
  std::string path_;
};

}  // namespace tiltfeed::desk
