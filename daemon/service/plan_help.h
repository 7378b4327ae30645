#pragma once
// What this service plans for another machine of the shop: one order at a time, in a folder of its own, at
// the lowest priority.

#include <optional>
#include <string>
#include <vector>

#include "daemon/service/planner.h"
#include "daemon/shop/shop_plans.h"

namespace tiltfeed::daemon {

/// Files without a name get these names in the folder, in place of what has them. Errors: kIo.
Result<void> name_files(const std::string& folder, const std::vector<int>& files,
                        const std::vector<std::string>& names);
/// Of what is planned: program, map, CL file, report.
const std::vector<std::string>& plan_outputs();

/// Properties: 1 Nothing of the order becomes part of a name. 2 What it leaves behind is gone with the next
/// order, and with the next service.
class PlanHelper {
 public:
  /// SPOOL/shop_plan, which is emptied.
  explicit PlanHelper(const std::string& spool);
  bool has_order() const { return order_.has_value(); }
  const std::string& id() const { return order_->id; }
  const std::string& folder() const { return folder_; }
  /// Errors: kIo. Requires: it has none.
  Result<void> begin(const PlanTaken& order, const std::vector<int>& files);
  /// The processor is needed here. It stays until it is settled.
  void give_back();
  /// True: it has ended, which nobody was told yet.
  bool tick();
  /// Nobody waits for this order of ours any more.
  void settle(const std::string& id);
  std::optional<PlanHelp> told() const;
  /// "planning X for Y".
  std::string text() const;

 private:
  void clear() const;
  std::string folder_;
  std::optional<PlanTaken> order_;
  PlanProcess process_;
  HelpState state_ = HelpState::kPlanning;
  std::string note_;
};

}  // namespace tiltfeed::daemon
