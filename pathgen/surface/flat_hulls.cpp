#include "pathgen/surface/flat_hulls.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "kinematics/basics/units.h"
#include "pathgen/surface/contact_hull.h"

namespace tiltfeed::pathgen {

namespace {

/// A hull up to this radius, against its distance from the axis feature, is flattened to first order; beyond,
/// its ball bounds it.
constexpr double kMaxCellShare = 0.15;
/// Most corners of a hull that keeps its polygon; more become a box.
constexpr std::size_t kMostCorners = 6;
/// Patches from one that is asked for to the one worked on: a microsecond. Of large parts what a patch needs
/// lies anywhere in memory.
constexpr std::size_t kFetchAhead = 12;
/// Patches between two looks at the user's word.
constexpr std::size_t kPatchesPerLook = 16;

/// Turns patches into hulls.
class HullMaker {
 public:
  HullMaker(const ClSurface& surface, const Deformation& map, double smallest, FlatHulls& out)
      : surface_(surface), map_(map), smallest_(smallest), out_(out), contact_(surface, map) {}

  void add(PatchId patch) {
    patch_ = patch;
    piece_ = &surface_.piece(patch);
    const ClSurface::Core core = surface_.core(patch);
    const Ball ball = ball_about(core.points());
    const Deformation::Aim aim = map_.aim(ball.centre);
    note_near(aim.away, ball);
    const bool both = surface_.sides() == Sides::kBoth && core.count != 2;
    for (int side = 1; side >= (both ? -1 : 1); side -= 2) {
      side_ = side;
      if (away(aim, ball.radius + piece_->outer)) continue;
      const ContactHull::Reach reach = contact_.take(patch, side);
      if (reach == ContactHull::Reach::kNone) continue;
      if (reach != ContactHull::Reach::kBounded) return add_wide(core);  // all there is, on either side
      add_core(core);
    }
  }

 private:
  struct Ball {
    Point<Part> centre;
    double radius = 0.0;  ///< of steps as they bend the map: in line mode square to the line
    double whole = 0.0;   ///< of all of them
  };
  /// About the mean of the points.
  Ball ball_about(std::span<const Point<Part>> points) const {
    Vec3 sum;
    for (Point<Part> p : points) sum = sum + from_origin(p);
    const Point<Part> centre = Point<Part>{} + sum * (1.0 / static_cast<double>(points.size()));
    double radius = 0.0, whole = 0.0;
    for (Point<Part> p : points) {
      radius = std::max(radius, squared_length(map_.bending(p - centre)));
      whole = std::max(whole, squared_length(p - centre));
    }
    return {centre, std::sqrt(radius), std::sqrt(whole)};
  }

  /// Notes a patch that may lie within reach of the point, line or circle (inside work), or of the axis of
  /// Theta (circle): it reaches into columns in which it has no CL point. `ball`: about the feature, `away`
  /// from there.
  void note_near(Deformation::Distances away, const Ball& ball) {
    const bool inside_work = map_.s() < 0.0, circle = map_.frame().mode == AxisMode::kCircle;
    const double round = piece_->flat + piece_->corner + std::abs(piece_->above_reference);
    const double reach = ball.radius + round;
    if (((inside_work && away.rho < reach) || (circle && away.r < reach)) &&
        piece_->part == ToolPart::kCutter)
      out_.near.push_back({patch_, ball.centre, ball.whole + round});
  }

  /// Does the patch turn away from the tool, whose axis line comes within `radius` of the place of `aim`?
  bool away(const Deformation::Aim& aim, double radius) const {
    const double turning = map_.turning_length(aim.away) - radius;
    return turning > 0.0 && surface_.faces_away(patch_, side_, aim.axis, radius / turning);
  }

  void add_core(const ClSurface::Core& core) {
    contact_.place(core.points());
    if (contact_.points().empty()) return;  // turned away from the tool
    const Ball ball = ball_about(contact_.points());
    const double radius = ball.radius + contact_.margin();
    const Deformation::Tangent at = map_.tangent(ball.centre);
    if (away(at.aim, radius)) return;
    if (radius < kMaxCellShare * std::min(at.aim.away.r, at.aim.away.rho)) return add_hull(ball, at);
    // The longest side, as it bends the map, is halved, until none is worth it.
    double longest = 0.0;
    std::size_t from = 0;
    for (std::size_t k = 0; k < (core.count == 3 ? 3 : core.count - 1); ++k)
      if (const double side = length(map_.bending(core.corner[(k + 1) % core.count] - core.corner[k]));
          side > longest)
        longest = side, from = k;
    if (longest < smallest_ || longest < contact_.margin())
      return add_ball(ball.centre, radius, ball.whole + contact_.margin());
    const Point<Part> a = core.corner[from], b = core.corner[(from + 1) % core.count],
                      middle = lerp(a, b, 0.5);
    const Point<Part> other = core.count == 3 ? core.corner[(from + 2) % 3] : Point<Part>{};
    add_core({{a, middle, other}, core.count});
    add_core({{middle, b, other}, core.count});
  }

  /// Contact normals all round: the reference is within the tool's reach of the feature.
  void add_wide(const ClSurface::Core& core) {
    const double reach = std::max(piece_->flat + piece_->corner, piece_->outer);
    const Point<Part> p = core.corner[0], q = core.corner[core.count - 1];
    const double half = distance(p, q) / 2.0;
    const Point<Part> middle = lerp(p, q, 0.5);
    if (half <= std::max(reach, smallest_)) return add_ball(middle, half + reach, half + reach);
    add_wide({{p, middle, {}}, 2});
    add_wide({{middle, q, {}}, 2});
  }

  bool x_is_angle() const { return map_.period_x() > 0.0; }
  bool y_is_angle() const { return map_.frame().mode != AxisMode::kFixed; }
  /// Of the patch; asked for by several hulls.
  double highest_reference() {
    if (top_of_ != patch_) top_of_ = patch_, top_ = pathgen::highest_reference(surface_, map_, patch_);
    return top_ + 2.0 * kSeam * (piece_->flat + piece_->corner);
  }
  /// `top`: z' of the highest place of the ball's centre; `rho`: of the furthest from the axis feature.
  void push(std::uint32_t count, double pad_x, double pad_y, double top, double rho) {
    double largest = 0.0;
    for (auto c = out_.corners.end() - count; c != out_.corners.end(); ++c)
      largest = std::max({largest, std::abs(static_cast<double>(c->x)), std::abs(static_cast<double>(c->y))});
    const double rounding = kSingle * largest;
    out_.hulls.push_back({patch_, static_cast<std::uint32_t>(out_.corners.size() - count), count,
                          static_cast<float>(pad_x * (1.0 + kSingle) + rounding),
                          static_cast<float>(pad_y * (1.0 + kSingle) + rounding)});
    top -= piece_->above_reference;
    if (!piece_->is_ball_at_reference()) top = std::min(top, highest_reference());
    out_.hulls.back().top = static_cast<float>(top + kSingle * std::abs(top));
    out_.furthest = std::max(out_.furthest, rho);
  }

  /// (S2) The hull's corners, flattened to first order about its middle, and what that leaves out.
  void add_hull(const Ball& ball, const Deformation::Tangent& at) {
    const std::span<const Point<Part>> hull = contact_.points();
    const Point<Flat> middle = map_.flatten(ball.centre);
    const bool box = hull.size() > kMostCorners || hull.size() < 3;
    constexpr double kFar = std::numeric_limits<double>::infinity();
    Vec3 low{kFar, kFar, 0.0}, high{-kFar, -kFar, -kFar};
    for (Point<Part> p : hull) {
      const Vec3 d = p - ball.centre;
      const double x = dot(at.x, d), y = dot(at.y, d);
      high.z = std::max(high.z, dot(at.aim.axis, d));
      if (box) {
        low = {std::min(low.x, x), std::min(low.y, y), 0.0};
        high = {std::max(high.x, x), std::max(high.y, y), high.z};
      } else {
        put(middle.x + x, middle.y + y);
      }
    }
    if (box) put(middle.x + low.x, middle.y + low.y), put(middle.x + high.x, middle.y + high.y);
    // A patch is accepted kSeam beyond its border, where a slice may run between two patches.
    const double margin = contact_.margin() + 2.0 * kSeam * (piece_->flat + piece_->corner);
    const Deformation::Distances away = at.aim.away,
                                 least{away.rho - ball.radius - margin, away.r - ball.radius - margin};
    const Deformation::Bend bend = map_.bend(least, ball.radius);
    push(box ? 2 : static_cast<std::uint32_t>(hull.size()),
         bend.x + margin * (x_is_angle() ? map_.scale_x() / least.r : 1.0),
         bend.y + margin * (y_is_angle() ? map_.scale_y() / least.rho : 1.0),
         middle.z + high.z + bend.z + margin, away.rho + ball.radius + margin);
  }

  void put(double x, double y) { out_.corners.push_back({static_cast<float>(x), static_cast<float>(y)}); }

  /// (S3) Everything within `radius` of `centre`, as it bends the map: an angle of asin(radius / distance) to
  /// each side; `whole`: how far it reaches along a line.
  void add_ball(Point<Part> centre, double radius, double whole) {
    const auto half_angle = [](double size, double away_by) {
      return away_by > size ? std::asin(size / away_by) : kPi;
    };
    const Point<Flat> flat = map_.flatten(centre);
    const Deformation::Distances from = map_.distances(centre);
    double half_x = whole, half_y = radius;
    if (x_is_angle()) half_x = map_.scale_x() * half_angle(radius, from.r);
    if (y_is_angle()) half_y = map_.scale_y() * half_angle(radius, from.rho);
    put(flat.x, flat.y), put(flat.x, flat.y);
    push(2, half_x, half_y, flat.z + radius, from.rho + radius);
  }

  const ClSurface& surface_;
  const Deformation& map_;
  double smallest_;
  FlatHulls& out_;
  PatchId patch_ = 0;
  const ToolPiece* piece_ = nullptr;
  int side_ = 1;
  ContactHull contact_;
  PatchId top_of_ = std::numeric_limits<PatchId>::max();
  double top_ = 0.0;  ///< of the patch top_of_
};

}  // namespace

FlatHulls make_flat_hulls(const ClSurface& surface, const Deformation& deformation, double smallest,
                          const ReportShare& report, const std::function<bool(PatchId)>& wanted) {
  // Worked on side by side; fixed, so that the result is the same for any number of threads.
  constexpr std::size_t kBlocks = 64;
  std::array<FlatHulls, kBlocks> blocks;
  const std::size_t patches = surface.patch_count();
  Watch watch(report, patches);
  tbb::parallel_for(std::size_t{0}, kBlocks, [&](std::size_t b) {
    HullMaker maker(surface, deformation, smallest, blocks[b]);
    for (std::size_t p = patches * b / kBlocks; p < patches * (b + 1) / kBlocks; ++p) {
      if (p % kPatchesPerLook == 0 && !watch.next(kPatchesPerLook)) return;
      if (p + kFetchAhead < patches) surface.fetch(static_cast<PatchId>(p + kFetchAhead));
      if (surface.is_idle(static_cast<PatchId>(p))) continue;
      if (!wanted || wanted(static_cast<PatchId>(p))) maker.add(static_cast<PatchId>(p));
    }
  });
  // Joined in their order, each moved to its place by itself.
  std::array<std::size_t, kBlocks + 1> hulls{}, corners{};
  for (std::size_t b = 0; b < kBlocks; ++b) {
    hulls[b + 1] = hulls[b] + blocks[b].hulls.size();
    corners[b + 1] = corners[b] + blocks[b].corners.size();
  }
  FlatHulls all;
  all.hulls.resize(hulls.back());
  all.corners.resize(corners.back());
  for (const FlatHulls& block : blocks) {
    all.near.insert(all.near.end(), block.near.begin(), block.near.end());
    all.furthest = std::max(all.furthest, block.furthest);
  }
  tbb::parallel_for(std::size_t{0}, kBlocks, [&](std::size_t b) {
    const FlatHulls block = std::move(blocks[b]);  // gives its memory back
    auto to = all.hulls.begin() + static_cast<std::ptrdiff_t>(hulls[b]);
    for (FlatHull hull : block.hulls) {
      hull.first += static_cast<std::uint32_t>(corners[b]);
      *to++ = hull;
    }
    std::copy(block.corners.begin(), block.corners.end(),
              all.corners.begin() + static_cast<std::ptrdiff_t>(corners[b]));
  });
  return all;
}

}  // namespace tiltfeed::pathgen
