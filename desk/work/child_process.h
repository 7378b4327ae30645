#pragma once
// A program that works for the desk: started, heard, interrupted, waited for.

#include <string>
#include <vector>

#include "kinematics/basics/result.h"

namespace tiltfeed::desk {

/// How a child ended: its exit status, or minus the signal's number.
struct ChildEnd {
  int status = 0;
  std::string text;  ///< the last kKept bytes of what it said on both outputs
};

/// Properties: it gets none of our descriptors; it dies with this process; its outputs never block it. The
/// destructor kills it and waits.
class ChildProcess {
 public:
  static constexpr std::size_t kKept = 64 * 1024;

  /// words[0] is the program's path. Errors: kIo.
  static Result<ChildProcess> start(const std::vector<std::string>& words);
  /// The same for one that is talked to.
  static Result<ChildProcess> start_talk(const std::vector<std::string>& words);
  ChildProcess(ChildProcess&& other) noexcept;
  ChildProcess& operator=(ChildProcess&&) = delete;
  ~ChildProcess();

  /// Readable when it says something; at its end, too.
  int descriptor() const { return hear_; }
  /// Reads what it has said. True: it has closed its outputs, and end() does not wait for long.
  bool listen();
  /// A line to its input. False: it takes no more; it has ended, or does not listen.
  bool say(const std::string& line);
  /// The whole lines of what it has said, which are then forgotten.
  std::vector<std::string> take_lines();
  void interrupt();
  /// Waits for it.
  ChildEnd end();

 private:
  ChildProcess(int pid, int hear, int say) : pid_(pid), hear_(hear), say_(say) {}
  static Result<ChildProcess> start_with(const std::vector<std::string>& words, int input, int say);
  int pid_ = -1, hear_ = -1, say_ = -1;
  std::string said_;
};

}  // namespace tiltfeed::desk
