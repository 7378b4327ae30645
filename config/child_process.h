#pragma once
// A program of ours in a process of its own, which ends with what started it; and one whose lines are heard.

#include <functional>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/beside_program.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::config {

/// At most one process. It is killed and waited for where its owner goes first.
class ChildProcess {
 public:
  ChildProcess() = default;
  ChildProcess(ChildProcess&& other) noexcept;
  ChildProcess& operator=(ChildProcess&& other) noexcept;
  ~ChildProcess() { end(); }

  /// As spawn_program, which `folder` goes to. Requires: it has none. 0 or errno.
  int start(const std::vector<std::string>& words, std::initializer_list<HandedFile> files,
            const std::string& folder = "");
  bool runs() const { return pid_ >= 0; }
  int pid() const { return pid_; }  ///< -1: none
  /// Nothing while it runs, or where there is none; its status (waitpid) when it has ended, once.
  std::optional<int> ended();
  /// Waits for its end: its status. Requires: it runs.
  int wait();
  /// Kills it and waits, if there is one.
  void end();

 private:
  int pid_ = -1;
};

/// One that is given a file, and says lines on its output and its errors. Among them "progress SHARE".
class HeardProcess {
 public:
  /// The file's descriptor as the process has it: /dev/fd/3.
  static constexpr int kFile = 3;

  HeardProcess() = default;
  HeardProcess(HeardProcess&& other) noexcept;
  HeardProcess& operator=(HeardProcess&&) = delete;
  ~HeardProcess();

  /// Starts words[0] with the file of descriptor `file`. `told`: it waits for what tell() says on its
  /// standard input. 0 or errno.
  int start(const std::vector<std::string>& words, int file, bool told = false);
  /// If it has ended already nobody hears this. The line's end is part of `line`.
  void tell(std::string_view line) const;
  /// Until it says no more. `take` gets each line that is no progress, without its end. `progress` gets the
  /// last share, ten times a second at least; may be empty. Errors: kCancelled, where `progress` says so.
  Result<void> listen(const std::function<bool(double)>& progress,
                      const std::function<void(const std::string&)>& take);
  /// Waits for its end: its status.
  int wait() { return child_.wait(); }

 private:
  ChildProcess child_;
  int tell_ = -1, hear_ = -1;
};

/// What a process said, for a message: without `speaker`, which its first line begins with. Of one that said
/// nothing or was ended by a signal, that.
std::string last_word_of(std::string said, std::string_view speaker, int status);

}  // namespace tiltfeed::config
