#pragma once
// The plan on the desk: `tiltfeed plan` as a process of its own, followed and cancelled.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "desk/api/cut_work.h"
#include "desk/api/part_work.h"
#include "desk/http/http_message.h"
#include "desk/work/child_process.h"

namespace tiltfeed::desk {

/// What is planned: files of this computer, and which text and part they were.
struct PlanInput {
  std::string job, stl, machine;
  std::uint64_t job_id = 0, part_id = 0;
  std::string operation = {};                         ///< planned alone; empty: all of the job
  std::string optimise = {};                          ///< as `tiltfeed plan --optimise`; empty: not
  std::vector<CutOperation> operations = {{"", ""}};  ///< of the program, in its order
};

class PlanWork {
 public:
  /// `program`: tiltfeed; `folder`: where the plan's files are kept.
  PlanWork(std::string program, std::string folder, Teller tell)
      : program_(std::move(program)), folder_(std::move(folder)), tell_(std::move(tell)) {}

  /// In place of the plan before. Errors: kUsage: one is in work; kIo.
  Result<void> start(const PlanInput& input);
  /// Errors: kUsage: none is in work.
  Result<void> cancel();

  /// JSON: null without a plan; else id, job, part (their ids), operation and optimise where they were asked
  /// for, state (planning, planned, refused, cancelled), while planning stage and percent, error when
  /// refused.
  std::string describe() const;
  Reply program() const { return file("part.nc", "text/plain; charset=utf-8"); }
  Reply drawing() const { return file("path.f32", "application/octet-stream"); }
  Reply map() const { return file("part.map", "application/octet-stream"); }
  Reply report() const { return file("report.json", "application/json"); }

  bool is_planned() const { return state_ == "planned"; }
  const PlanInput& input() const { return input_; }
  /// What a cut of it needs. Requires: is_planned().
  CutInput cut_input() const {
    return {folder_ + "/plan.yaml", folder_ + "/plan.stl", input_.machine, folder_ + "/part.nc", id_,
            input_.operation,       input_.operations};
  }

  bool is_working() const { return child_.has_value(); }
  int descriptor() const { return child_ ? child_->descriptor() : -1; }
  void hear();
  /// Tells the stage where it has changed. Due every kLook while it works.
  void look();
  static constexpr int kLookMs = 200;

 private:
  Reply file(const char* name, const char* type) const;

  std::string program_, folder_;
  Teller tell_;
  std::uint64_t id_ = 0;
  PlanInput input_;
  std::string state_, error_, progress_;
  bool cancelled_ = false;
  std::optional<ChildProcess> child_;
};

}  // namespace tiltfeed::desk
