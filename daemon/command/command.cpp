#include "daemon/command/command.h"

#include <sys/mman.h>
#include <unistd.h>

#include <cstdlib>
#include <iostream>

#include "config/job.h"
#include "config/yaml_tree.h"

namespace tiltfeed::daemon {

int complain(const Error& error) {
  std::cerr << "tiltfeed: " << error.message << "\n";
  return error.code == Code::kUsage ? kExitWrongUse : kExitFailed;
}

int show_json(const std::string& object) {
  std::cout << object << "\n";
  return kExitDone;
}

int open_written_out(const std::string& job) {
  const Result<std::string> text = config::read_config_text(job);
  const Result<std::string> whole =
      text ? config::with_tool_written_out(*text, job, {}) : Result<std::string>(text);
  const int fd = whole ? ::memfd_create("job.yaml", MFD_CLOEXEC) : -1;
  if (fd >= 0 && ::write(fd, whole->data(), whole->size()) != static_cast<ssize_t>(whole->size())) {
    ::close(fd);
    return -1;
  }
  return fd;
}

std::string service_socket() {
  const char* const set = std::getenv("TILTFEED_SOCKET");
  return set != nullptr ? set : kDefaultSocket;
}

}  // namespace tiltfeed::daemon
