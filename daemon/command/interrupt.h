#pragma once
// SIGINT and SIGTERM: a word to those who look for it, and an end for those who do not.

#include <string>

namespace tiltfeed::daemon {

/// From now on SIGINT and SIGTERM are heard by interrupted(). Call it before any thread is started.
void hear_interrupts();
bool interrupted();

/// While it lives, an interrupt ends the process at the latest kGrace after it, whatever the process is at:
/// work that does not look for the user's word, or a file that does not answer. What is left unfinished of
/// OutputFile is removed first. At most one at a time.
class PromptEnd {
 public:
  static constexpr int kGraceMs = 250;
  PromptEnd();
  ~PromptEnd();
  PromptEnd(const PromptEnd&) = delete;
  PromptEnd& operator=(const PromptEnd&) = delete;
};

}  // namespace tiltfeed::daemon
