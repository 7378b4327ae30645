#pragma once
// Files that appear whole or not at all: written beside their name, made durable and renamed into place.

#include <cstdint>
#include <memory>
#include <ostream>
#include <string>
#include <string_view>
#include <vector>

#include "kinematics/basics/result.h"

namespace tiltfeed::config {

/// Removes what it wrote unless `commit` succeeds: until then the file of that name is as it was. The name
/// "-" is the standard output, which gets all of it when it is committed.
class OutputFile {
 public:
  /// Opens a new file beside `path`, under a name that nobody can foresee, and removes what writers of `path`
  /// that were killed left there; a file that somebody still writes is locked, and stays. Errors: kUsage: as
  /// check_outputs; kIo when the folder cannot be written.
  static Result<OutputFile> open(const std::string& path);
  OutputFile(OutputFile&& other) noexcept;
  OutputFile& operator=(OutputFile&&) = delete;
  ~OutputFile();

  std::ostream& stream();
  /// What was written can be read from this descriptor as soon as it is flushed, and its bytes go on their
  /// way to the disk. Errors: kIo.
  Result<void> flush();
  int descriptor() const;
  /// Other bytes in the place of some that were flushed. Errors: kIo.
  Result<void> overwrite(std::uint64_t at, std::string_view bytes);
  /// Syncs, renames, syncs the folder. Errors: kIo with the file and the reason (a full disk shows here at
  /// the latest), after which nothing is left behind.
  Result<void> commit();
  /// The same of files that belong together: all are synced before the first takes its name, so that a disk
  /// that fails leaves all as they were.
  static Result<void> commit_all(std::vector<OutputFile>& files);

  /// Removes what is not committed of all files, and leaves nobody to commit any more: for a process that
  /// ends at once. Returns the paths that were committed, with commas.
  static std::string abandon();

 private:
  struct State;
  explicit OutputFile(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// A file of a command, and the option or the key that names it.
struct NamedFile {
  std::string name, path;  ///< an empty path is none
};

/// Before any work: an output is another one or an input, by whatever path; it is there and no regular file
/// (a symbolic link is none: links are followed for reading, never for replacing); its folder is not there
/// or cannot be written. Errors: kUsage, kIo.
Result<void> check_outputs(const std::vector<NamedFile>& outputs, const std::vector<NamedFile>& inputs);

/// Writes all of it at once. Errors: as OutputFile.
Result<void> write_file(const std::string& path, std::string_view bytes);

}  // namespace tiltfeed::config
