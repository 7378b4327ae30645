#include "daemon/command/verify_command.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "daemon/plan/proof_process.h"

namespace tiltfeed {

Error run_verify(const std::vector<std::string>& arguments) {
  const auto beside = program_beside("tiltfeed-sim");
  if (!beside) return {Code::kIo, "verify: " + beside.error().message};
  const std::string& program = *beside;
  std::vector<std::string> all{program, "verify"};
  all.insert(all.end(), arguments.begin(), arguments.end());
  std::vector<char*> words;
  for (std::string& word : all) words.push_back(word.data());
  words.push_back(nullptr);
  execv(program.c_str(), words.data());
  return {Code::kIo, program + ": " + std::strerror(errno) + "; it belongs beside tiltfeed: install both"};
}

}  // namespace tiltfeed
