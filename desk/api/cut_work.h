#pragma once
// The planned program cut on the simulated machine: `tiltfeed-sim verify` as a process of its own, followed
// and cancelled; what it found, and what the run before found, to compare.

#include <optional>
#include <string>
#include <vector>

#include "desk/api/part_work.h"
#include "desk/http/access_check.h"
#include "desk/http/http_message.h"
#include "desk/work/child_process.h"

namespace tiltfeed::desk {

/// An operation that is cut, and the folder that `tiltfeed verify` makes for it; both empty: the job has one.
struct CutOperation {
  std::string name, folder;
};

/// Files of this computer, and which plan they are.
struct CutInput {
  std::string job, stl, machine, program;
  std::uint64_t plan_id = 0;
  std::string operation = {};                         ///< alone in the program; empty: all are
  std::vector<CutOperation> operations = {{"", ""}};  ///< of the program, in its order
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
  /// error when refused, verdict (passed, incomplete, failed), before (is there one) and operations when
  /// done.
  std::string describe() const;
  // Of the operation of this name; empty: the first.
  Reply view(const std::string& operation) const { return file("cut.view", kOctets, operation); }
  Reply page(const std::string& operation) const { return file("index.html", kOctets, operation); }
  Reply report(const std::string& operation) const {
    return file("report.json", "application/json", operation);
  }
  Reply before(const std::string& operation) const;

  bool is_working() const { return child_.has_value(); }
  int descriptor() const { return child_ ? child_->descriptor() : -1; }
  void hear();
  /// Tells the stage where it has changed.
  void look();

 private:
  Reply file(const char* name, const char* type, const std::string& operation) const;
  std::string at(const char* name) const { return folder_ + "/" + name; }
  /// Of what `tiltfeed verify` has written about an operation; empty: not there. `folder`: "cut", "before".
  std::string path_of(const char* folder, const CutOperation& operation, const char* name) const;
  static const CutOperation* find(const std::vector<CutOperation>& operations, const std::string& name);

  std::string program_, folder_;
  Teller tell_;
  std::uint64_t id_ = 0;
  CutInput input_;
  std::vector<CutOperation> before_;   ///< of the run before
  std::vector<std::string> verdicts_;  ///< by operation
  std::string state_, error_, progress_, verdict_;
  bool cancelled_ = false;
  std::optional<ChildProcess> child_;
};

}  // namespace tiltfeed::desk
