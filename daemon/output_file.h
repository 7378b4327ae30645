#pragma once
// Files that appear whole or not at all: written beside their name and renamed into place.

#include <fstream>
#include <string>

#include "kinematics/result.h"

namespace tiltfeed {

/// Removes what it wrote unless `commit` succeeds.
class OutputFile {
 public:
  /// Errors: kIo when the folder cannot be written.
  static Result<OutputFile> open(const std::string& path);
  OutputFile(OutputFile&& other) noexcept;
  OutputFile& operator=(OutputFile&&) = delete;
  ~OutputFile();

  std::ostream& stream() { return out_; }
  /// Flushes and renames. Errors: kIo (a full disk shows here), after which nothing is left behind.
  Result<void> commit();

  /// Removes what is not committed of all files, and leaves nobody to commit any more: for a process that
  /// ends at once. Returns the paths that were committed, with commas.
  static std::string abandon();

 private:
  explicit OutputFile(const std::string& path);
  std::string path_, temporary_;
  std::ofstream out_;
};

}  // namespace tiltfeed
