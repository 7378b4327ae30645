#pragma once
// The planned program cut on the simulated machine: `tiltfeed-sim verify` as a process of its own, followed
// and cancelled; what it found, and what the run before found, to compare.

#include <optional>
#include <string>

#include "desk/api/part_work.h"
#include "desk/http/http_message.h"
#include "desk/work/child_process.h"

namespace tiltfeed::desk {

/// Files of this computer, and which plan they are.
struct CutInput {
  std::string job, stl, machine, program;
  std::uint64_t plan_id = 0;
};

class CutWork {
 public:
  /// `program`: tiltfeed-sim; `folder`: where its files are kept.
  CutWork(std::string program, std::string folder, Teller tell)
      : program_(std::move(program)), folder_(std::move(folder)), tell_(std::move(tell)) {}

  /// What was found last becomes the run before. Errors: kUsage: one is in work; kIo.
  Result<void> start(const CutInput& input);
  /// Errors: kUsage: none is in work.
  Result<void> cancel();

  /// JSON: null, or id, plan, state (working, done, refused, cancelled), while working stage and percent,
  /// error when refused, verdict (passed, incomplete, failed) and before (is there one) when done.
  std::string describe() const;
  Reply view() const { return file("cut/cut.view", "application/octet-stream", state_ == "done"); }
  Reply before() const { return file("before.view", "application/octet-stream", has_before_); }
  Reply page() const { return file("cut/index.html", "application/octet-stream", state_ == "done"); }
  Reply report() const { return file("cut/report.json", "application/json", state_ == "done"); }

  bool is_working() const { return child_.has_value(); }
  int descriptor() const { return child_ ? child_->descriptor() : -1; }
  void hear();
  /// Tells the stage where it has changed.
  void look();

 private:
  Reply file(const char* name, const char* type, bool there) const;
  std::string at(const char* name) const { return folder_ + "/" + name; }

  std::string program_, folder_;
  Teller tell_;
  std::uint64_t id_ = 0;
  CutInput input_;
  std::string state_, error_, progress_, verdict_;
  bool cancelled_ = false, has_before_ = false;
  std::optional<ChildProcess> child_;
};

}  // namespace tiltfeed::desk
