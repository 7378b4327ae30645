#include "daemon/files/durable.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <vector>

namespace tiltfeed::daemon {

int sync_folder(const std::string& folder) {
  const int fd = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return -errno;
  const int result = ::fsync(fd) == 0 ? 0 : -errno;
  ::close(fd);
  return result;
}

int make_folders(const std::string& path) {
  namespace fs = std::filesystem;
  std::vector<fs::path> missing;
  std::error_code failed;
  for (fs::path at = fs::path(path + "/").parent_path(); !at.empty() && !fs::exists(at, failed) && !failed;
       at = at.parent_path())
    missing.push_back(at);
  for (auto at = missing.rbegin(); at != missing.rend() && !failed; ++at) {
    fs::create_directory(*at, failed);
    if (failed) break;
    const std::string above = at->parent_path().string();
    if (const int synced = sync_folder(above.empty() ? "." : above); synced < 0) return synced;
  }
  return failed ? -failed.value() : 0;
}

}  // namespace tiltfeed::daemon
