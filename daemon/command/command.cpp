#include "daemon/command/command.h"

#include <sys/mman.h>
#include <unistd.h>

#include <cstdlib>
#include <iostream>
#include <nlohmann/json.hpp>

#include "config/job.h"
#include "config/output_file.h"
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

int give_text(const std::string& text, const std::string& out, bool as_json) {
  if (as_json)
    return show_json(
        nlohmann::json({{"text", text}}).dump(-1, ' ', true, nlohmann::json::error_handler_t::replace));
  const Result<void> written = config::write_file(out, text);
  return written ? kExitDone : complain(written.error());
}

std::string above_zero(const std::string& number) {
  return std::strtod(number.c_str(), nullptr) <= 0.0 ? "'" + number + "' is not a number above 0" : "";
}

std::string utc_text(std::time_t at) {
  std::tm parts{};
  ::gmtime_r(&at, &parts);
  char text[32];
  return {text, std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &parts)};
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
