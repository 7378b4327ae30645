#include "daemon/command/command.h"

#include <cstdlib>
#include <iostream>

namespace tiltfeed::daemon {

int complain(const Error& error) {
  std::cerr << "tiltfeed: " << error.message << "\n";
  return error.code == Code::kUsage ? kExitWrongUse : kExitFailed;
}

int show_json(const std::string& object) {
  std::cout << object << "\n";
  return kExitDone;
}

std::string service_socket() {
  const char* const set = std::getenv("TILTFEED_SOCKET");
  return set != nullptr ? set : kDefaultSocket;
}

}  // namespace tiltfeed::daemon
