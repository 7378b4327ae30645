#include "daemon/verify_command.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

namespace tiltfeed {

Error run_verify(const std::vector<std::string>& arguments) {
  std::error_code error;
  const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", error);
  if (error) return {Code::kIo, "verify: /proc/self/exe: " + error.message()};
  const std::string program = (self.parent_path() / "tiltfeed-sim").string();
  std::vector<std::string> all{program, "simulate"};
  all.insert(all.end(), arguments.begin(), arguments.end());
  std::vector<char*> words;
  for (std::string& word : all) words.push_back(word.data());
  words.push_back(nullptr);
  execv(program.c_str(), words.data());
  return {Code::kIo, program + ": " + std::strerror(errno) + "; it belongs beside tiltfeed: install both"};
}

}  // namespace tiltfeed
