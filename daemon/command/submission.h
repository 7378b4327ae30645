#pragma once
// What goes to a service: a job's text and its part, or a program.

#include <string>
#include <utility>
#include <vector>

#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

struct Submission {
  std::string name;  ///< the file's, without folder and ending
  bool program = false;
  std::vector<int> files;  ///< open

  /// A program by its ending, else a job, which is read first. Errors: as load_job; kInput: a file of the job
  /// that does not go with it; kIo.
  static Result<Submission> open(const std::string& file);
  Submission() = default;
  Submission(Submission&& other) noexcept
      : name(std::move(other.name)), program(other.program), files(std::exchange(other.files, {})) {}
  Submission& operator=(Submission&&) = delete;
  ~Submission();
};

}  // namespace tiltfeed::daemon
