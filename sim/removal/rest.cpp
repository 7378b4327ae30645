#include "sim/removal/rest.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "sim/basics/workers.h"
#include "sim/motion/forward.h"
#include "sim/removal/rest_cause.h"

namespace tiltfeed::sim {
namespace {

/// Sine of the least lean over the tool axis that rows can follow: walls are z_level's.
constexpr double kSteepest = 0.26;
/// Directions tried where the axis is free.
constexpr int kDirections = 200;
/// Cosine of the furthest that a free axis leans from the normal.
constexpr double kLeastFacing = 0.09;
/// The axis at the reference depends on the reference: so often it is asked again.
constexpr int kAxisSteps = 4;
/// A pose this much (mm) too near counts as clear: rounding.
constexpr double kRounding = 1e-6;
/// Patches that are held against the tool, at most: of more an even share.
constexpr std::size_t kMostPatches = 20'000;
constexpr std::size_t kTasks = 64;
/// Places of which the cause is looked for, at most: of more an even share.
constexpr std::size_t kMostCauses = 256;
/// Where the part is curved passes leave more than on a plane; so many times as much is laid to them.
constexpr double kCurved = 2.0;
/// More directions than an indexed job may have, and by how much two of them differ, rad.
constexpr std::size_t kMostIndexed = 64;
constexpr double kSameDirection = 1e-4;

bool in_polygon(const std::vector<std::array<double, 2>>& corners, double x, double y) {
  bool inside = corners.empty();
  for (std::size_t i = 0, j = corners.size() - 1; i < corners.size(); j = i++) {
    const auto &a = corners[i], &b = corners[j];
    if ((a[1] > y) != (b[1] > y) && x < (b[0] - a[0]) * (y - a[1]) / (b[1] - a[1]) + a[0]) inside = !inside;
  }
  return inside;
}

/// Stock that is to stay, along the part's normal.
double stay(const pathgen::PlanOptions& plan) {
  return plan.allowance + plan.radial_stock + plan.axial_stock;
}

bool is_free(const pathgen::PlanOptions& plan) {
  return plan.axis.mode == pathgen::AxisMode::kFree || plan.axis.mode == pathgen::AxisMode::kIndexed;
}

}  // namespace

Reach::Reach(const config::Job& job, const PartDistance& surface, std::vector<Vec3> directions)
    : job_(job),
      surface_(surface),
      solid_(job.plan.cutter),
      directions_(std::move(directions)),
      least_facing_(std::max(kLeastFacing, kSteepest)) {
  if (!directions_.empty() && job.plan.axis.mode == pathgen::AxisMode::kIndexed)
    least_facing_ = std::max(least_facing_, std::cos(job.plan.indexed.steepest.radians()));
  if (!is_free(job.plan) || !directions_.empty()) return;
  // Evenly over the sphere (Fibonacci).
  for (int i = 0; i < kDirections; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / kDirections, r = std::sqrt(1.0 - z * z);
    const double turn = i * kPi * (3.0 - std::sqrt(5.0));
    const Vec3 d{r * std::cos(turn), r * std::sin(turn), z};
    if (angle_between(d, job.plan.up) <= job.plan.tilt_max.radians()) directions_.push_back(d);
  }
}

/// The tool axis of the job's field; nothing on the feature itself.
std::optional<Vec3> Reach::field_axis(Point<Part> reference) const {
  const pathgen::AxisFrame& f = job_.plan.axis;
  const double sign = f.sense == pathgen::Sense::kOutward ? 1.0 : -1.0;
  Vec3 away = reference - f.origin;
  switch (f.mode) {
    case pathgen::AxisMode::kPoint:
      break;
    case pathgen::AxisMode::kLine:
      away = away - f.t * dot(away, f.t);
      break;
    case pathgen::AxisMode::kCircle: {
      const Vec3 flat = f.t * dot(away, f.t) + f.n * dot(away, f.n);
      if (length(flat) == 0.0) return std::nullopt;
      away = away - flat * (f.circle_radius / length(flat));
      break;
    }
    default:
      return f.n;
  }
  if (length(away) == 0.0) return std::nullopt;
  return normalized(away) * sign;
}

Pose Reach::touching(Point<Part> place, Vec3 normal, Vec3 axis) const {
  const pathgen::Cutter& cutter = job_.plan.cutter;
  const double corner = cutter.nose_radius();
  const double flat =
      cutter.type == pathgen::CutterType::kBullNose || cutter.type == pathgen::CutterType::kFlat
          ? cutter.radius() - corner
          : 0.0;
  const Vec3 aside = normal - axis * dot(normal, axis);
  const Vec3 out = length(aside) > 1e-9 ? normalized(aside) : Vec3{};
  // Facets of a hollow stand up beside the plane of each of them: what they keep off the tool by less than
  // the tolerance is no hindrance.
  const double off = stay(job_.plan) + job_.plan.tolerance;
  return {place + normal * (off + corner) + out * flat - axis * corner, axis};
}

Point<Part> Reach::reference_of(const Pose& pose) const {
  return pose.tip + pose.axis * job_.plan.cutter.nose_radius();
}

/// In the coordinates of the axis mode, as the job gives them.
bool Reach::contained(Point<Part> reference) const {
  const pathgen::Containment& in = job_.plan.containment;
  const pathgen::AxisFrame& f = job_.plan.axis;
  const Vec3 p = reference - f.origin,
             b = cross(f.n, f.t) * (f.sense == pathgen::Sense::kOutward ? 1.0 : -1.0);
  double first = dot(p, f.t), second = dot(p, b), height = dot(p, f.n);
  if (f.mode == pathgen::AxisMode::kLine) {
    second = std::atan2(dot(p, b), dot(p, f.n)), height = std::hypot(dot(p, b), dot(p, f.n));
  } else if (f.mode == pathgen::AxisMode::kPoint || f.mode == pathgen::AxisMode::kCircle) {
    const double across = std::hypot(dot(p, f.t), dot(p, f.n)) - f.circle_radius_or_zero();
    first = std::atan2(dot(p, f.t), dot(p, f.n));
    second = std::atan2(dot(p, b), across), height = std::hypot(across, dot(p, b));
  } else if (is_free(job_.plan)) {
    first = reference.x, second = reference.y, height = reference.z;
  }
  return in.first.contains(first) && in.second.contains(second) && in.height.contains(height) &&
         in_polygon(in.boundary, first, second);
}

bool Reach::clear(const Pose& pose) const {
  const pathgen::PlanOptions& plan = job_.plan;
  if (angle_between(pose.axis, plan.up) > plan.tilt_max.radians()) return false;
  const auto free_by = [&](ToolPart part, double distance) {
    return solid_.clearance(surface_, pose, part, distance).value >= distance - kRounding;
  };
  // Only what keeps the tool away for sure is in its way.
  return free_by(ToolPart::kCutter, plan.allowance) &&
         (plan.shank.reaction == pathgen::Reaction::kReport ||
          free_by(ToolPart::kShank, plan.shank.clearance)) &&
         (plan.holder.reaction == pathgen::Reaction::kReport ||
          free_by(ToolPart::kHolder, plan.holder.clearance));
}

/// Clear where it stands, and drawn back along its axis by the job's clearance, as any path has to?
bool Reach::comes_off(const Pose& pose) const {
  const double away = job_.plan.links.clearance;
  const double steps = std::ceil(away / job_.plan.cutter.radius());
  for (double k = 0.0; k <= steps; ++k)
    if (!clear({pose.tip + pose.axis * (steps > 0.0 ? away * k / steps : 0.0), pose.axis})) return false;
  return true;
}

bool Reach::touches(Point<Part> place, Vec3 normal) const {
  if (is_free(job_.plan)) {
    return std::any_of(directions_.begin(), directions_.end(), [&](Vec3 axis) {
      if (dot(axis, normal) < least_facing_) return false;
      const Pose pose = touching(place, normal, axis);
      return contained(reference_of(pose)) && comes_off(pose);
    });
  }
  std::optional<Vec3> axis = field_axis(place + normal * job_.plan.cutter.nose_radius());
  Pose pose;
  for (int k = 0; k < kAxisSteps && axis; ++k) {
    if (dot(*axis, normal) < kSteepest) return false;
    pose = touching(place, normal, *axis);
    axis = field_axis(reference_of(pose));
  }
  if (!axis) return false;
  pose = touching(place, normal, *axis);
  return contained(reference_of(pose)) && comes_off(pose);
}

namespace {

/// What of a patch is over the limit.
struct Over {
  std::uint32_t patch = 0;
  double area = 0.0, left = 0.0;  ///< of those probes; of the one in their middle
  std::uint64_t probe = 0;        ///< that one
  bool never = false;
  std::uint32_t move = Probes::kNever;  ///< that came nearest to that one
  double apart = 0.0;                   ///< of passes that may leave so much; 0: it is not the slope
};

std::vector<Over> over_limit(const Probes& probes, double limit) {
  std::vector<Over> all;
  const Patches& patches = probes.patches();
  std::vector<std::uint64_t> wrong;
  for (std::uint32_t p = 0; p < patches.mesh.facets.size(); ++p) {
    wrong.clear();
    for (std::uint64_t i = patches.first[p]; i < patches.first[p + 1]; ++i) {
      const Probes::Value v = probes.value(i);
      if (v.move == Probes::kNever || v.left > limit) wrong.push_back(i);
    }
    if (wrong.empty()) continue;
    const std::uint64_t middle = wrong[wrong.size() / 2];
    const Probes::Value v = probes.value(middle);
    const bool never = v.move == Probes::kNever;
    all.push_back({p,
                   probes.patch_area(p) * static_cast<double>(wrong.size()) /
                       static_cast<double>(patches.first[p + 1] - patches.first[p]),
                   never ? probes.reach() : v.left, middle, never, v.move, 0.0});
  }
  return all;
}

}  // namespace

namespace {

/// Facets of the part's file that alone are to be machined, rising; nothing: all.
std::optional<std::vector<std::uint32_t>> only_facets(const pathgen::PlanOptions& plan) {
  if (!plan.only_faces) return std::nullopt;
  std::vector<std::uint32_t> facets = plan.only_faces->mesh.source;
  std::sort(facets.begin(), facets.end());
  return facets;
}

/// How far apart passes lie by that place, mm; 0 where they would leave less than there is: something else is
/// in the way.
double apart_at(const config::Job& job, const PassDistances& passes, const Over& over, Point<Part> place,
                Vec3 normal) {
  if (over.never) return 0.0;
  const pathgen::Cutter& cutter = job.plan.cutter;
  const double apart = passes.apart(place + normal * (cutter.nose_radius() + stay(job.plan)), over.move,
                                    2.0 * cutter.diameter);
  const double left = stay(job.plan) + job.plan.tolerance + kCurved * left_between(cutter, apart);
  return over.left <= left ? apart : 0.0;
}

/// In which an indexed job's program cuts; none where those are too many to be indexed ones.
std::vector<Vec3> cut_directions(const config::Job& job, const ExecutedPath& path) {
  std::vector<Vec3> directions;
  if (job.plan.axis.mode != pathgen::AxisMode::kIndexed) return directions;
  const FrameChain chain(job.machine.model, job.setup);
  for (const ExecutedMove& move : path.moves) {
    if (move.rapid) continue;
    const Vec3 axis = chain(move.to).axis;
    const bool known = std::any_of(directions.begin(), directions.end(),
                                   [&](Vec3 one) { return length(one - axis) < kSameDirection; });
    if (known) continue;
    if (directions.size() == kMostIndexed) return {};
    directions.push_back(axis);
  }
  return directions;
}

}  // namespace

Rest find_rest(const config::Job& job, const ExecutedPath& path, const Probes& probes, double limit,
               int threads) {
  Rest rest;
  rest.limit = limit;
  std::vector<Over> all = over_limit(probes, limit);
  double whole = 0.0, asked = 0.0;
  for (const Over& over : all) whole += over.area;
  if (all.size() > kMostPatches) {
    std::vector<Over> some;
    for (std::size_t i = 0; i < kMostPatches; ++i) some.push_back(all[i * all.size() / kMostPatches]);
    all = std::move(some);
  }
  const std::vector<Vec3> directions = cut_directions(job, path);
  const Reach reach(job, probes.surface(), directions);
  std::optional<Reach> anyhow;  // by other directions than the program's
  if (!directions.empty()) anyhow.emplace(job, probes.surface());
  const std::optional<std::vector<std::uint32_t>> only = only_facets(job.plan);
  const auto asked_for = [&](std::uint32_t patch) {
    return !only || std::binary_search(only->begin(), only->end(), probes.patches().mesh.source[patch]);
  };
  enum : std::uint8_t { kNot, kElsewhere, kReached };
  std::vector<std::uint8_t> reached(all.size(), kNot);
  in_parallel(kTasks, threads, [&](std::size_t task) {
    for (std::size_t i = all.size() * task / kTasks; i < all.size() * (task + 1) / kTasks; ++i) {
      if (!asked_for(all[i].patch)) continue;
      const Point<Part> place = probes.place(all[i].patch, all[i].probe);
      const Vec3 normal = probes.patches().normal[all[i].patch];
      if (reach.touches(place, normal))
        reached[i] = kReached;
      else if (anyhow && anyhow->touches(place, normal))
        reached[i] = kElsewhere;
    }
  });
  std::vector<std::size_t> told;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (reached[i] == kReached) told.push_back(i);
  const std::size_t share = 1 + told.size() / kMostCauses;
  const std::optional<PassDistances> passes =
      told.empty() ? std::nullopt : std::make_optional<PassDistances>(job, path);
  in_parallel(kTasks, threads, [&](std::size_t task) {
    for (std::size_t k = task * share; k < told.size(); k += kTasks * share) {
      Over& over = all[told[k]];
      over.apart = apart_at(job, *passes, over, probes.place(over.patch, over.probe),
                            probes.patches().normal[over.patch]);
    }
  });
  double causes = 0.0;  // area of those whose cause was looked for
  for (std::size_t k = 0; k < told.size(); k += share) {
    const Over& over = all[told[k]];
    causes += over.area;
    if (over.apart > 0.0) rest.between_passes += over.area, rest.apart = std::max(rest.apart, over.apart);
  }
  for (std::size_t i = 0; i < all.size(); ++i) {
    asked += all[i].area;
    if (reached[i] == kElsewhere) rest.elsewhere += all[i].area;
    if (reached[i] != kReached) continue;
    rest.area += all[i].area;
    if (all[i].left <= rest.left) continue;
    rest.left = all[i].left, rest.never_cut = all[i].never;
    rest.facet = probes.patches().mesh.source[all[i].patch];
    rest.place = probes.place(all[i].patch, all[i].probe);
  }
  if (causes > 0.0) rest.between_passes *= rest.area / causes;
  for (double* area : {&rest.area, &rest.elsewhere, &rest.between_passes})
    if (asked > 0.0) *area *= whole / asked;
  rest.out_of_reach = whole - rest.area;
  return rest;
}

}  // namespace tiltfeed::sim
