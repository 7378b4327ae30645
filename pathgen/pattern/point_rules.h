#pragma once
// Which points of the envelope may be cut, and what was refused.

#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "pathgen/envelope/envelope.h"
#include "pathgen/options/plan_options.h"
#include "pathgen/options/rest_reason.h"
#include "pathgen/pattern/region.h"
#include "pathgen/surface/cl_field.h"
#include "pathgen/tool/face_containment.h"

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
  /// Points over a fixture where there is nothing of the part to cut, and points away from the chosen faces.
  std::uint64_t beside = 0;
  void add(const RejectedPoints& other);
};

class PointRules {
 public:
  PointRules(const PlanOptions& options, const ClField& field)
      : options_(options),
        surface_(field.surface),
        field_(field),
        region_(options.containment, field.deformation),
        least_upright_(std::cos(options.tilt_max.radians()) - kRounding) {
    if (options.only_faces) faces_ = std::make_shared<const FaceContainment>(options);
  }
  /// Why the point may not be cut; nothing where it may.
  std::optional<RestReason> refusal(const EnvelopePoint& p) const;
  /// Does the cutter come near to a face that is to be machined? Always true where no faces are chosen.
  bool near_faces(const EnvelopePoint& p) const { return !faces_ || faces_->near(p.centre, p.axis); }
  /// The same on a way between two passes.
  bool near_faces_on_way(const EnvelopePoint& p) const {
    return !faces_ || faces_->near_on_way(p.centre, p.axis);
  }
  /// The same as refusal(), noted in `refusals`; so are points that stay but are raised. Points away from the
  /// chosen faces are but counted.
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
  std::shared_ptr<const FaceContainment> faces_;
  static constexpr double kRounding = 1e-15;
  double least_upright_;  ///< cosine of the tilt, at tilt_max
};

}  // namespace tiltfeed::pathgen
