#pragma once
// A program whose bodies come too near to each other, planned anew: the tilt on its other side, links higher
// along the tool or by way of the retract, the turn of the axis before or behind the way across, swings at
// the retract in another way. The proof judges each attempt.

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "daemon/plan/operation_plan.h"
#include "daemon/plan/proof_process.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

/// A link that goes another way than it was planned.
struct AvoidedLink {
  std::string operation;  ///< its name; empty: the job is one
  std::size_t link = 0;   ///< from 0, the way to the first cut
  LinkChoice choice;
};

/// A swing at the retract, in front of this link's cut, that goes another way than it was planned.
struct AvoidedSwing {
  std::string operation;
  std::size_t link = 0;
  SwingChoice choice;
};

/// What keeps the bodies of a program apart.
struct Avoidance {
  std::string collision;    ///< what came too near as it was planned at first
  bool other_side = false;  ///< the tilt stands on its other side
  std::vector<AvoidedLink> links;
  std::vector<AvoidedSwing> swings;
  std::size_t attempts = 0;  ///< programs that were proven or refused after the first
};

/// For people.
std::string avoidance_text(const Avoidance& avoidance);

/// With other links and swings there are no more attempts than this on a side of the tilt.
inline constexpr std::size_t kMostLinkAttempts = 3 * kLinkChoices.size() + 2 * kSwingChoices.size();

/// `once`: joints, text and proof of the operations as they are chosen. `prover`: that of the last attempt;
/// null: it came to none.
struct AvoidanceCalls {
  std::function<Result<void>()> once;
  std::function<const ProofProcess*()> prover;
};

/// The first attempt that is proven, in this order: as planned; the tilt on its other side; then on either
/// side with other ways for those links and swings that collide. What it took stands in `avoidance`, where
/// the first attempt was none. Errors: that of the first attempt, with what was tried; kCancelled.
Result<void> avoid_collisions(const std::vector<std::unique_ptr<OperationPlan>>& operations,
                              const AvoidanceCalls& calls, const PlanListener& told,
                              std::optional<Avoidance>& avoidance);

}  // namespace tiltfeed::daemon
