#include "daemon/service/watched_folder.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <optional>
#include <system_error>

namespace tiltfeed::daemon {

namespace {

namespace fs = std::filesystem;

/// Nothing: no regular file.
std::optional<FileStamp> stamp_of(const struct stat& status) {
  if (!S_ISREG(status.st_mode)) return std::nullopt;
  return FileStamp{static_cast<std::int64_t>(status.st_dev), static_cast<std::int64_t>(status.st_ino),
                   status.st_size, status.st_mtim.tv_sec, status.st_mtim.tv_nsec};
}

std::optional<FileStamp> stamp_at(const std::string& path) {
  struct stat status {};
  return ::lstat(path.c_str(), &status) == 0 ? stamp_of(status) : std::nullopt;
}

}  // namespace

WatchedFolder look_into(const std::string& folder, const SeenFiles& seen) {
  WatchedFolder found;
  std::error_code failed;
  SeenFiles others;
  for (fs::directory_iterator at(folder, failed), end; !failed && at != end; at.increment(failed)) {
    const std::string path = at->path().string();
    if (at->path().extension() != ".nc") continue;
    const std::optional<FileStamp> stamp = stamp_at(path);
    if (!stamp) continue;
    const auto known = seen.find(path);
    (known != seen.end() && known->second == *stamp ? found.seen : others)[path] = *stamp;
  }
  if (failed) {
    found.trouble = folder + ": cannot be read: " + failed.message();
    found.seen = seen;
    return found;
  }
  for (const auto& [path, none] : others) {
    const int fd = ::open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
    struct stat status {};
    if (fd < 0) continue;
    const std::optional<FileStamp> stamp = ::fstat(fd, &status) == 0 ? stamp_of(status) : std::nullopt;
    found.files = std::make_shared<HandedFiles>(std::vector<int>{fd});
    if (!stamp) continue;
    found.path = path;
    found.stamp = *stamp;
    break;
  }
  return found;
}

bool remove_taken(const std::string& path, const FileStamp& stamp) {
  return stamp_at(path) != stamp || ::unlink(path.c_str()) == 0;
}

}  // namespace tiltfeed::daemon
