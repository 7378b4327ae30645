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
  const int why = errno;
  // tiltfeed-sim comes with tiltfeed; the others have packages of their own, named as they are.
  if (why == ENOENT && program != "tiltfeed-sim")
    return {Code::kIo, *beside + " is not installed: it is the package " + program +
                           ", which has to be of tiltfeed's version (dpkg -s tiltfeed)"};
  return {Code::kIo, *beside + ": " + std::strerror(why) + "; it belongs beside tiltfeed: install both"};
}

}  // namespace tiltfeed::daemon
