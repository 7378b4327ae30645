#include "pathgen/mesh/file_descriptor.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace tiltfeed::pathgen {

FileDescriptor::~FileDescriptor() {
  if (fd_ >= 0) ::close(fd_);
}

bool FileDescriptor::close() { return ::close(std::exchange(fd_, -1)) == 0; }

tl::unexpected<Error> io_error(const std::string& path, const std::string& what) {
  return fail(Code::kIo, path + ": " + what + ": " + std::strerror(errno));
}

}  // namespace tiltfeed::pathgen
