#include "daemon/command/hand_over.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "config/beside_program.h"

namespace tiltfeed::daemon {

Error hand_over(const std::string& program, const std::vector<std::string>& words,
                const std::vector<std::string>& arguments) {
  const auto beside = config::program_beside(program);
  if (!beside) return {Code::kIo, program + ": " + beside.error().message};
  std::vector<std::string> all{*beside};
  all.insert(all.end(), words.begin(), words.end());
  all.insert(all.end(), arguments.begin(), arguments.end());
  std::vector<char*> pointers;
  for (std::string& word : all) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  execv(beside->c_str(), pointers.data());
  return {Code::kIo, *beside + ": " + std::strerror(errno) + "; it belongs beside tiltfeed: install both"};
}

}  // namespace tiltfeed::daemon
