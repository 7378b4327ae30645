#pragma once
// Which points of the envelope may be cut, and what was refused.

#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "pathgen/envelope/envelope.h"
#include "pathgen/options/plan_options.h"
#include "pathgen/options/rest_reason.h"
#include "pathgen/pattern/region.h"
#include "pathgen/surface/cl_field.h"

namespace tiltfeed::pathgen {

/// Points refused, by RestReason, and the patches that stand behind shank and holder refusals.
struct RejectedPoints {
  std::array<std::uint64_t, kRestReasons> count{};
  std::array<std::uint64_t, kRestReasons>
      raised{};  ///< points that stay, raised clear of the part by shank or holder
  std::vector<PatchId> patches;
  struct OfFixture {
    std::uint64_t points = 0;
    Point<Part> first;  ///< place of the CL reference
  };
  std::map<std::uint32_t, OfFixture> fixtures;  ///< what each body kept the tool from, by its number
  std::uint64_t beside = 0;  ///< points over a fixture where there is nothing of the part to cut
  void add(const RejectedPoints& other);
};

class PointRules {
 public:
  PointRules(const PlanOptions& options, const ClField& field)
      : options_(options),
        surface_(field.surface),
        field_(field),
        region_(options.containment, field.deformation),
        least_upright_(std::cos(options.tilt_max.radians()) - kRounding) {}
  /// Why the point may not be cut; nothing where it may.
  std::optional<RestReason> refusal(const EnvelopePoint& p) const;
  /// The same, noted in `refusals`; so are points that stay but are raised.
  bool may_cut(const EnvelopePoint& p, RejectedPoints& refusals) const;
  /// What of the tool touches there: shank or holder keep the point clear of the surface.
  const ToolPiece& touching(const EnvelopePoint& p) const { return surface_.piece(p.patch); }
  /// Notes a point that `held`, a patch of shank, holder or a fixture, keeps the tool from.
  void refuse(const EnvelopePoint& held, RejectedPoints& refusals) const;
  const Region& region() const { return region_; }

 private:
  const PlanOptions& options_;
  const ClSurface& surface_;
  const ClField& field_;
  Region region_;
  static constexpr double kRounding = 1e-15;
  double least_upright_;  ///< cosine of the tilt, at tilt_max
};

}  // namespace tiltfeed::pathgen
