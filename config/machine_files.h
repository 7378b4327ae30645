#pragma once
// The machine profiles that come with the program: config/machines/*.yaml, as they were when it was built.

#include <vector>

namespace tiltfeed::config {

struct MachineFile {
  const char *name, *text;  ///< the file's name without its ending; the profile
};

/// Sorted by name.
const std::vector<MachineFile>& machine_files();

}  // namespace tiltfeed::config
