#include "config/standard_output.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <iostream>

namespace tiltfeed::config {

void open_standard_streams() {
  // Nobody reads any more, or a file may not grow further: an error of that write, as any other.
  for (const int signal : {SIGPIPE, SIGXFSZ}) std::signal(signal, SIG_IGN);
  // The lowest free descriptor is the one that is closed. For reading only: writing stays an error.
  for (const int fd : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (::fcntl(fd, F_GETFD) < 0 && errno == EBADF) static_cast<void>(::open("/dev/null", O_RDONLY));
}

int close_standard_output(const char* program, int status) {
  errno = 0;
  std::cout.flush();
  const bool failed = std::fflush(stdout) != 0 || std::ferror(stdout) != 0 || !std::cout;
  if (!failed) return status;
  const int reason = errno;
  std::fprintf(stderr, "%s: the standard output cannot be written: %s\n", program,
               reason != 0 ? std::strerror(reason) : "an earlier part of it was refused");
  return status == 0 ? 1 : status;
}

}  // namespace tiltfeed::config
