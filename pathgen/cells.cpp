#include "pathgen/cells.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "kinematics/units.h"
#include "pathgen/contact_hull.h"

namespace tiltfeed {

namespace {

/// Corner images bound a cell up to this size against its distance from the axis feature; beyond, its ball
/// does.
constexpr double kMaxCellShare = 0.25;
/// (S2) Half the square of the smallest circle or ball about a set, over the square of its size [Jung 1901]:
/// a function with second derivative M leaves its linear interpolation by at most M times that.
constexpr double kBendOfTriangle = 1.0 / 6.0, kBendOfHull = 3.0 / 16.0;
/// Most corners of a cell that keeps its hull; more become a box.
constexpr std::size_t kMostCorners = 6;
/// Largest relative rounding of a coordinate in single precision, doubled.
constexpr double kSingle = 1.2e-7;
/// Blocks of patches worked on side by side; fixed, so that the result is the same for any number of threads.
constexpr std::size_t kBlocks = 64;

/// Turns patches into cells.
class CellMaker {
 public:
  CellMaker(const ClSurface& surface, const Deformation& map, double smallest, Cells& out)
      : surface_(surface), map_(map), smallest_(smallest), out_(out), contact_(surface, map) {}

  void add(PatchId patch) {
    patch_ = patch;
    piece_ = &surface_.piece(patch);
    const ClSurface::Core core = surface_.core(patch);
    add_near(core);
    const bool both = surface_.sides() == Sides::kBoth && core.count != 2;
    for (int side = 1; side >= (both ? -1 : 1); side -= 2) {
      side_ = side;
      const ContactHull::Reach reach = contact_.take(patch, side);
      if (reach == ContactHull::Reach::kNone) continue;
      if (reach == ContactHull::Reach::kBounded) {
        add_core(core);
      } else if (reach == ContactHull::Reach::kAround || !all_away(core)) {
        return add_wide(core);  // that is all there is, on either side
      }
    }
  }

 private:
  /// Notes a patch that may lie within reach of the point, line or circle (inside work), or of the axis of
  /// Theta (circle): it reaches into columns in which it has no CL point.
  void add_near(const ClSurface::Core& core) {
    const bool inside_work = map_.s() < 0.0, circle = map_.frame().mode == AxisMode::kCircle;
    if ((!inside_work && !circle) || piece_->part != ToolPart::kCutter) return;
    Point<Part> centre;
    double reach = 0.0;
    for (Point<Part> p : core.points()) centre = centre + from_origin(p) / core.count;
    for (Point<Part> p : core.points()) reach = std::max(reach, squared_length(p - centre));
    reach = std::sqrt(reach) + piece_->flat + piece_->corner;
    if ((inside_work && rho_of(centre) < reach) || (circle && r_of(centre) < reach))
      out_.near.push_back(patch_);
  }

  bool all_away(const ClSurface::Core& core) const {
    if (core.count > 1) return false;
    const double reach = piece_->outer, turning = map_.turning_length(map_.distances(core.corner[0])) - reach;
    if (turning <= reach) return false;
    const double spread = reach / turning;
    return surface_.faces_away(patch_, side_, map_.axis_at(core.corner[0]), spread);
  }

  /// Where a hull lies against the axis feature.
  struct Frame {
    double size = 0.0;          ///< longest distance between two points
    double rho = 0.0, r = 0.0;  ///< least possible distance from the feature, and from the axis of Theta
    double pad_x = 0.0, pad_y = 0.0;  ///< (S2) bend of the flat image against its corners
    double rise = 0.0;                ///< the same of z'
    bool linear = false;              ///< corners and pads bound the image
    Vec3 axis;                        ///< at the first point
  };

  Frame frame_of(std::span<const Point<Part>> points) const {
    Frame f;
    double rho = std::numeric_limits<double>::infinity(), r = rho;
    for (std::size_t i = 0; i < points.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) f.size = std::max(f.size, squared_length(points[i] - points[j]));
      const Deformation::Distances d = map_.distances(points[i]);
      rho = std::min(rho, d.rho), r = std::min(r, d.r);
    }
    f.size = std::sqrt(f.size) + contact_.margin();
    f.axis = map_.axis_at(points[0]);
    f.linear = f.size < kMaxCellShare * std::min(r, rho);
    f.rho = rho - f.size, f.r = r - f.size;
    if (!f.linear || map_.frame().mode == AxisMode::kFixed) return f;
    const double bend = f.size * f.size * (points.size() <= 3 ? kBendOfTriangle : kBendOfHull);
    f.pad_x = map_.scale_x() * bend / (f.r * f.r);
    f.pad_y = map_.scale_y() * bend * (1.0 / (f.rho * f.rho) + 1.0 / (f.r * f.rho));
    f.rise = bend * (1.0 / f.rho + 1.0 / f.r);
    return f;
  }

  bool away(const Frame& f) const {
    const double turning = map_.turning_length({f.rho, f.r});
    return turning > 0.0 && surface_.faces_away(patch_, side_, f.axis, f.size / turning);
  }

  void add_core(const ClSurface::Core& core) {
    contact_.place(core.points());
    const std::vector<Point<Part>>& hull = contact_.points();
    if (hull.empty()) return;  // turned away from the tool
    const Frame f = frame_of(hull);
    if (away(f)) return;
    if (f.linear) return add_hull(f);
    const double extent = core.count > 1 ? distance(core.corner[0], core.corner[core.count - 1]) : 0.0;
    const double second = core.count > 2 ? std::max(distance(core.corner[0], core.corner[1]),
                                                    distance(core.corner[1], core.corner[2]))
                                         : 0.0;
    if (std::max(extent, second) < smallest_ || std::max(extent, second) < contact_.margin()) {
      Point<Part> mean;
      for (Point<Part> p : hull) mean = mean + from_origin(p) / static_cast<double>(hull.size());
      return add_ball(mean, f.size);
    }
    const auto& [a, b, c] = core.corner;
    const Point<Part> ab = lerp(a, b, 0.5);
    if (core.count == 2) {
      add_core({{a, ab, {}}, 2});
      add_core({{ab, b, {}}, 2});
      return;
    }
    const Point<Part> bc = lerp(b, c, 0.5), ca = lerp(c, a, 0.5);
    add_core({{a, ab, ca}, 3});
    add_core({{ab, b, bc}, 3});
    add_core({{ca, bc, c}, 3});
    add_core({{ab, bc, ca}, 3});
  }

  /// Contact normals all round: the reference is within the tool's reach of the feature.
  void add_wide(const ClSurface::Core& core) {
    const double reach = std::max(piece_->flat + piece_->corner, piece_->outer);
    const Point<Part> p = core.corner[0], q = core.corner[core.count - 1];
    const double half = distance(p, q) / 2.0;
    const Point<Part> middle = lerp(p, q, 0.5);
    if (half <= std::max(reach, smallest_)) return add_ball(middle, half + reach);
    add_wide({{p, middle, {}}, 2});
    add_wide({{middle, q, {}}, 2});
  }

  bool x_is_angle() const { return map_.period_x() > 0.0; }
  bool y_is_angle() const { return map_.frame().mode != AxisMode::kFixed; }
  /// Distance from the point, line or circle.
  double rho_of(Point<Part> p) const { return map_.distances(p).rho; }
  /// Distance from the axis of Theta.
  double r_of(Point<Part> p) const { return map_.distances(p).r; }
  static double nearest_turn(double value, double to, double period) {
    return period > 0.0 ? value + period * std::round((to - value) / period) : value;
  }

  /// `top`: z' of the highest place of the ball's centre.
  void push(std::uint32_t count, double pad_x, double pad_y, double top) {
    double largest = 0.0;
    for (auto c = out_.corners.end() - count; c != out_.corners.end(); ++c)
      largest = std::max({largest, std::abs(static_cast<double>(c->x)), std::abs(static_cast<double>(c->y))});
    const double rounding = kSingle * largest;
    out_.cells.push_back({patch_, static_cast<std::uint32_t>(out_.corners.size() - count), count,
                          static_cast<float>(pad_x * (1.0 + kSingle) + rounding),
                          static_cast<float>(pad_y * (1.0 + kSingle) + rounding)});
    top -= piece_->above_reference;
    out_.cells.back().top = static_cast<float>(top + kSingle * std::abs(top));
  }

  void add_hull(const Frame& f) {
    const std::vector<Point<Part>>& hull = contact_.points();
    const Point<Flat> first = map_.flatten(hull[0]);
    Point<Flat> low = first, high = first;
    const bool box = hull.size() > kMostCorners;
    for (Point<Part> p : hull) {
      const Point<Flat> flat = map_.flatten(p);
      const double x = nearest_turn(flat.x, first.x, map_.period_x());
      const double y = nearest_turn(flat.y, first.y, map_.period_y());
      low = {std::min(low.x, x), std::min(low.y, y), 0.0};
      high = {std::max(high.x, x), std::max(high.y, y), std::max(high.z, flat.z)};
      if (!box) out_.corners.push_back({static_cast<float>(x), static_cast<float>(y)});
    }
    if (box || hull.size() < 3) {
      if (!box) out_.corners.resize(out_.corners.size() - hull.size());
      out_.corners.push_back({static_cast<float>(low.x), static_cast<float>(low.y)});
      out_.corners.push_back({static_cast<float>(high.x), static_cast<float>(high.y)});
    }
    // A patch is accepted kSeam beyond its border, where a slice may run between two patches.
    const double margin = contact_.margin() + 2.0 * kSeam * (piece_->flat + piece_->corner);
    push(box || hull.size() < 3 ? 2 : static_cast<std::uint32_t>(hull.size()),
         f.pad_x + margin * (x_is_angle() ? map_.scale_x() / f.r : 1.0),
         f.pad_y + margin * (y_is_angle() ? map_.scale_y() / f.rho : 1.0), high.z + f.rise + margin);
  }

  /// (S3) Everything within `radius` of `centre`: an angle of asin(radius / distance) to each side.
  void add_ball(Point<Part> centre, double radius) {
    const auto half_angle = [](double size, double away_by) {
      return away_by > size ? std::asin(size / away_by) : kPi;
    };
    const Point<Flat> flat = map_.flatten(centre);
    double half_x = radius, half_y = radius;
    if (x_is_angle()) half_x = map_.scale_x() * half_angle(radius, r_of(centre));
    if (y_is_angle()) half_y = map_.scale_y() * half_angle(radius, rho_of(centre));
    const FlatCorner c{static_cast<float>(flat.x), static_cast<float>(flat.y)};
    out_.corners.push_back(c);
    out_.corners.push_back(c);
    push(2, half_x, half_y, flat.z + radius);
  }

  const ClSurface& surface_;
  const Deformation& map_;
  double smallest_;
  Cells& out_;
  PatchId patch_ = 0;
  const ToolPiece* piece_ = nullptr;
  int side_ = 1;
  ContactHull contact_;
};

}  // namespace

Cells make_cells(const ClSurface& surface, const Deformation& deformation, double smallest) {
  std::array<Cells, kBlocks> blocks;
  const std::size_t patches = surface.patch_count();
  tbb::parallel_for(std::size_t{0}, kBlocks, [&](std::size_t b) {
    CellMaker maker(surface, deformation, smallest, blocks[b]);
    for (std::size_t p = patches * b / kBlocks; p < patches * (b + 1) / kBlocks; ++p)
      maker.add(static_cast<PatchId>(p));
  });
  Cells all;
  std::size_t cells = 0, corners = 0;
  for (const Cells& block : blocks) cells += block.cells.size(), corners += block.corners.size();
  all.cells.reserve(cells);
  all.corners.reserve(corners);
  for (Cells& block : blocks) {
    for (Cell& cell : block.cells) cell.first += static_cast<std::uint32_t>(all.corners.size());
    all.cells.insert(all.cells.end(), block.cells.begin(), block.cells.end());
    all.corners.insert(all.corners.end(), block.corners.begin(), block.corners.end());
    all.near.insert(all.near.end(), block.near.begin(), block.near.end());
    block = {};
  }
  return all;
}

}  // namespace tiltfeed
