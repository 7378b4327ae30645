#pragma once
// The programs that are installed together: where they lie, and how one starts another.

#include <initializer_list>
#include <string>
#include <vector>

#include "kinematics/basics/result.h"

namespace tiltfeed::config {

/// The path of a program of this name in the folder of this one. Errors: kIo.
Result<std::string> program_beside(const std::string& name);

/// For spawn_program: this program as it runs, whatever its file has become. It is called by its file's name.
inline constexpr const char* kThisProgram = "/proc/self/exe";

/// A descriptor of this process as it is called in the one that is started.
struct HandedFile {
  int own, there;
};

/// Starts words[0] with these descriptors in `folder` (empty: this process's own), signals as usual; `pid`:
/// its number. Descriptors that are not handed over should close on exec, and none of them may be one that
/// `files` names as `there`. Standard input that is not handed over is /dev/null. Returns 0 or errno.
int spawn_program(int& pid, const std::vector<std::string>& words, std::initializer_list<HandedFile> files,
                  const std::string& folder = "");

}  // namespace tiltfeed::config
