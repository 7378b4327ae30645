#pragma once
// The machine of the job on the desk as the page draws it: `tiltfeed-sim machine` as a process of its own,
// anew whenever the job has changed.

#include <optional>
#include <string>

#include "desk/api/part_work.h"
#include "desk/http/http_message.h"
#include "desk/work/child_process.h"

namespace tiltfeed::desk {

class MachineWork {
 public:
  /// `program`: tiltfeed-sim; `folder`: where its file is kept.
  MachineWork(std::string program, std::string folder, Teller tell)
      : program_(std::move(program)), folder_(std::move(folder)), tell_(std::move(tell)) {}

  /// In place of what is in work: of the job's text as it is now. What cannot be started is told as a
  /// refusal.
  void start(const std::string& job, const std::string& machine, std::uint64_t job_id);
  /// JSON: null, or id, job and state (working, ready, refused), then with error.
  std::string describe() const;
  /// The numbers of the newest that is ready.
  Reply view() const;

  int descriptor() const { return child_ ? child_->descriptor() : -1; }
  void hear();

 private:
  void refuse(const std::string& why);

  std::string program_, folder_;
  Teller tell_;
  std::uint64_t id_ = 0, job_ = 0;
  std::string state_, error_;
  bool has_view_ = false;
  std::optional<ChildProcess> child_;
};

}  // namespace tiltfeed::desk
