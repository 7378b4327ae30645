#include "daemon/files/durable.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>

namespace tiltfeed {

int sync_folder(const std::string& folder) {
  const int fd = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return -errno;
  const int result = ::fsync(fd) == 0 ? 0 : -errno;
  ::close(fd);
  return result;
}

}  // namespace tiltfeed
