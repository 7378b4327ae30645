#pragma once
// The way from the shop's thread to the job service, which alone has the spool.

#include <memory>
#include <string>

#include "daemon/service/job_service_thread.h"
#include "daemon/shop/shop_plans.h"
#include "daemon/shop/shop_record.h"

namespace tiltfeed::daemon {

/// What is asked through it is done on the job service's loop, and waited for. A closed gate answers
/// kCancelled, and so does what was on its way when the job service ended.
class ShopGate {
 public:
  explicit ShopGate(const std::string& spool, const std::string& machine);
  void open(JobServiceThread& thread);
  void close();
  ShopLedger ledger() const;
  /// `version`: of this program.
  PlanLedger plans(const std::string& version) const;

 private:
  struct Way;
  std::shared_ptr<Way> way_;
};

}  // namespace tiltfeed::daemon
