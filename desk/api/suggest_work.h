#pragma once
// Axis proposals for the part on the desk: `tiltfeed suggest` as a process of its own, followed and
// cancelled.

#include <optional>
#include <string>

#include "desk/api/part_work.h"
#include "desk/work/child_process.h"

namespace tiltfeed::desk {

struct SuggestInput {
  std::string stl, unit, machine, cutter;
  std::uint64_t part_id = 0;
  std::vector<std::string> bodies = {};  ///< of the part; empty: all
};

class SuggestWork {
 public:
  /// `program`: tiltfeed; `folder`: where its files are kept.
  SuggestWork(std::string program, std::string folder, Teller tell)
      : program_(std::move(program)), folder_(std::move(folder)), tell_(std::move(tell)) {}

  /// In place of the one before. Errors: kIo.
  Result<void> start(const SuggestInput& input);
  /// Errors: kUsage: none is in work.
  Result<void> cancel();
  /// JSON: null, or id, part, cutter, state (working, ready, refused, cancelled), while working stage and
  /// percent, error when refused, proposals when ready.
  std::string describe() const;

  bool is_working() const { return child_.has_value(); }
  int descriptor() const { return child_ ? child_->descriptor() : -1; }
  void hear();
  /// Tells the stage where it has changed.
  void look();

 private:
  std::string program_, folder_;
  Teller tell_;
  std::uint64_t id_ = 0;
  SuggestInput input_;
  std::string state_, error_, progress_, found_;
  bool cancelled_ = false;
  std::optional<ChildProcess> child_;
};

}  // namespace tiltfeed::desk
