#include "pathgen/cells.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "kinematics/units.h"

namespace tiltfeed {

namespace {

/// Corner images bound a cell up to this size against its distance from the axis feature; beyond, its ball
/// does.
constexpr double kMaxCellShare = 0.25;
/// Cells are not split below this size (mm), nor below this share of the side step: there the point, line or
/// circle is inside or next to them.
constexpr double kSmallestCell = 0.1;
constexpr double kSmallestCellShare = 0.25;
/// Blocks of patches worked on side by side; fixed, so that the result is the same for any number of threads.
constexpr std::size_t kBlocks = 64;

/// Turns patches into cells.
class CellMaker {
 public:
  CellMaker(const ClSurface& surface, const Deformation& map, Along along, double smallest, CellBlock& out)
      : surface_(surface), map_(map), along_(along), smallest_(smallest), out_(out) {}

  void add(PatchId patch) {
    patch_ = patch;
    const bool both = surface_.sides() == Sides::kBoth;
    const bool edge = !surface_.is_face(patch) && !(surface_.core(patch).p == surface_.core(patch).q);
    add_near();
    for (side_ = 1; side_ >= (both && !edge ? -1 : 1); side_ -= 2)
      if (!add_side()) return;
  }

 private:
  /// Notes a patch that may lie within the radius of the point, line or circle (inside work), or of the axis
  /// of Theta (circle): it reaches into columns in which it has no CL point.
  void add_near() {
    const bool inside_work = map_.s() < 0.0, circle = map_.frame().mode == AxisMode::kCircle;
    if (!inside_work && !circle) return;
    std::array<Point<Part>, 3> corner;
    if (surface_.is_face(patch_)) {
      const auto& f = surface_.mesh().facets[patch_];
      for (std::size_t i = 0; i < 3; ++i) corner[i] = surface_.mesh().vertices[f[i]];
    } else {
      const ClSurface::Core core = surface_.core(patch_);
      corner = {core.p, core.q, core.q};
    }
    const Point<Part> centre =
        lerp(lerp(corner[0], corner[1], 0.5), corner[2], surface_.is_face(patch_) ? 1.0 / 3.0 : 0.0);
    double size = 0.0;
    for (Point<Part> p : corner) size = std::max(size, distance(centre, p));
    const double reach = size + surface_.radius();
    const bool near_feature = inside_work && rho_of(centre) < reach;
    const bool near_axis = circle && r_of(centre) < reach;
    if (near_feature || near_axis) out_.near.push_back(patch_);
  }

  /// False if it has added all there is, on either side.
  bool add_side() {
    if (surface_.is_face(patch_)) return add_face(), true;
    const ClSurface::Core core = surface_.core(patch_);
    surface_.hull(patch_, side_, hull_);
    if (hull_.empty()) return add_wide(core.p, core.q), false;
    if (!(core.p == core.q))
      return add_edge({hull_[0], hull_[1], hull_[2], hull_[3], hull_[4], hull_[5]}), true;
    const Frame f = frame_of(hull_);
    if (away(f)) return true;
    if (!f.linear) return add_ball(core.p, surface_.radius()), false;
    return add_box(hull_, f), true;
  }

  /// Where a hull lies against the axis feature.
  struct Frame {
    double size = 0.0;          ///< longest distance between two points
    double rho = 0.0, r = 0.0;  ///< least possible distance from the feature, and from the axis of Theta
    double pad_x = 0.0, pad_y = 0.0;  ///< (S2) bend of the flat image against its corners
    bool linear = false;              ///< corners and pads bound the image
    Vec3 axis;                        ///< at the first point
  };

  Frame frame_of(std::span<const Point<Part>> points) const {
    Frame f;
    const AxisFrame& axis = map_.frame();
    double rho = std::numeric_limits<double>::infinity(), r = rho;
    for (Point<Part> p : points) {
      for (Point<Part> q : points) f.size = std::max(f.size, squared_length(q - p));
      r = std::min(r, r_of(p));
      rho = std::min(rho, rho_of(p));
    }
    f.size = std::sqrt(f.size);
    f.axis = map_.axis_at(points[0]);
    if (axis.mode == AxisMode::kFixed) {
      f.linear = true;
      f.rho = f.r = std::numeric_limits<double>::infinity();
      return f;
    }
    if (axis.mode == AxisMode::kLine) r = std::numeric_limits<double>::infinity();
    f.linear = f.size < kMaxCellShare * std::min(r, rho);
    f.rho = rho - f.size, f.r = r - f.size;
    if (!f.linear) return f;
    const double bend = f.size * f.size / 4.0;
    if (axis.mode == AxisMode::kLine) {
      f.pad_y = map_.scale_y() * bend / (f.rho * f.rho);
    } else {
      f.pad_x = map_.scale_x() * bend / (f.r * f.r);
      f.pad_y = map_.scale_y() * bend * (1.0 / (f.rho * f.rho) + 1.0 / (f.r * f.rho));
    }
    return f;
  }

  bool away(const Frame& f) const {
    return f.rho > 0.0 &&
           surface_.faces_away(patch_, side_, f.axis, std::isinf(f.rho) ? 0.0 : f.size / f.rho);
  }

  void add_face() {
    const auto& facet = surface_.mesh().facets[patch_];
    const auto& v = surface_.mesh().vertices;
    const Vec3 up = surface_.facet_normal(patch_) * (side_ * surface_.radius());
    add_triangle({v[facet[0]] + up, v[facet[1]] + up, v[facet[2]] + up});
  }

  void add_triangle(const std::array<Point<Part>, 3>& t) {
    const Frame f = frame_of(t);
    if (away(f)) return;
    if (f.linear) return add_hull(t, f);
    if (f.size < smallest_) {
      const Point<Part> mean = lerp(lerp(t[0], t[1], 0.5), t[2], 1.0 / 3.0);
      return add_ball(mean, f.size);
    }
    const Point<Part> ab = lerp(t[0], t[1], 0.5), bc = lerp(t[1], t[2], 0.5), ca = lerp(t[2], t[0], 0.5);
    add_triangle({t[0], ab, ca});
    add_triangle({ab, t[1], bc});
    add_triangle({ca, bc, t[2]});
    add_triangle({ab, bc, ca});
  }

  /// Six points: three round each end.
  void add_edge(const std::array<Point<Part>, 6>& e) {
    const Frame f = frame_of(e);
    if (away(f)) return;
    if (f.linear) return add_hull(e, f);
    const double length_along = distance(e[0], e[3]), width = distance(e[0], e[1]);
    if (length_along > width && length_along > smallest_) {
      const std::array<Point<Part>, 3> mid{lerp(e[0], e[3], 0.5), lerp(e[1], e[4], 0.5),
                                           lerp(e[2], e[5], 0.5)};
      add_edge({e[0], e[1], e[2], mid[0], mid[1], mid[2]});
      add_edge({mid[0], mid[1], mid[2], e[3], e[4], e[5]});
    } else {
      add_ball(lerp(e[0], e[3], 0.5), f.size);
    }
  }

  void add_wide(Point<Part> p, Point<Part> q) {
    const double half = distance(p, q) / 2.0;
    if (half <= surface_.radius()) return add_ball(lerp(p, q, 0.5), half + surface_.radius());
    const Point<Part> middle = lerp(p, q, 0.5);
    add_wide(p, middle);
    add_wide(middle, q);
  }

  bool x_is_angle() const { return map_.period_x() > 0.0; }
  bool y_is_angle() const { return map_.frame().mode != AxisMode::kFixed; }
  /// Distance from the point, line or circle.
  double rho_of(Point<Part> p) const { return std::abs(map_.flatten(p).z); }
  /// Distance from the axis of Theta.
  double r_of(Point<Part> p) const {
    const Vec3 d = p - map_.frame().origin;
    return std::hypot(dot(d, map_.frame().t), dot(d, map_.frame().n));
  }

  FlatCorner corner(Point<Part> p) const {
    const Point<Flat> f = map_.flatten(p);
    return along_ == Along::kX ? FlatCorner{f.y, f.x} : FlatCorner{f.x, f.y};
  }
  double cross_period() const { return along_ == Along::kX ? map_.period_y() : map_.period_x(); }
  double run_period() const { return along_ == Along::kX ? map_.period_x() : map_.period_y(); }
  static double nearest_turn(double value, double to, double period) {
    return period > 0.0 ? value + period * std::round((to - value) / period) : value;
  }

  void push_cell(std::size_t count, double pad_x, double pad_y) {
    const bool x = along_ == Along::kX;
    out_.cells.push_back({patch_, static_cast<std::uint32_t>(out_.corners.size() - count),
                          static_cast<std::uint32_t>(count), x ? pad_y : pad_x, x ? pad_x : pad_y});
  }

  void add_hull(std::span<const Point<Part>> points, const Frame& f) {
    const FlatCorner first = corner(points[0]);
    for (Point<Part> p : points) {
      const FlatCorner c = corner(p);
      out_.corners.push_back(
          {nearest_turn(c.cross, first.cross, cross_period()), nearest_turn(c.run, first.run, run_period())});
    }
    // A patch is accepted kSeam beyond its border, where a slice may run between two patches.
    const double seam = 2.0 * kSeam * surface_.radius();
    push_cell(points.size(), f.pad_x + seam * (x_is_angle() ? map_.scale_x() / f.r : 1.0),
              f.pad_y + seam * (y_is_angle() ? map_.scale_y() / f.rho : 1.0));
  }

  void add_box(std::span<const Point<Part>> points, const Frame& f) {
    const std::size_t at = out_.corners.size();
    add_hull(points, f);
    FlatCorner low = out_.corners[at], high = low;
    for (std::size_t i = at; i < out_.corners.size(); ++i) {
      low = {std::min(low.cross, out_.corners[i].cross), std::min(low.run, out_.corners[i].run)};
      high = {std::max(high.cross, out_.corners[i].cross), std::max(high.run, out_.corners[i].run)};
    }
    out_.corners.resize(at);
    out_.corners.push_back(low);
    out_.corners.push_back(high);
    out_.cells.back().count = 2;
  }

  /// (S3) Everything within `radius` of `centre`: an angle of asin(radius / distance) to each side.
  void add_ball(Point<Part> centre, double radius) {
    const auto half_angle = [](double size, double away_by) {
      return away_by > size ? std::asin(size / away_by) : kPi;
    };
    const FlatCorner c = corner(centre);
    double half_x = radius, half_y = radius;
    if (x_is_angle()) half_x = map_.scale_x() * half_angle(radius, r_of(centre));
    if (y_is_angle()) half_y = map_.scale_y() * half_angle(radius, rho_of(centre));
    out_.corners.push_back(c);
    out_.corners.push_back(c);
    push_cell(2, half_x, half_y);
  }

  const ClSurface& surface_;
  const Deformation& map_;
  Along along_;
  double smallest_;
  CellBlock& out_;
  PatchId patch_ = 0;
  int side_ = 1;
  std::vector<Point<Part>> hull_;
};

}  // namespace

std::vector<CellBlock> make_cells(const ClSurface& surface, const Deformation& deformation, Along along,
                                  double side_step) {
  const double smallest = std::max(kSmallestCell, kSmallestCellShare * side_step);
  std::vector<CellBlock> blocks(kBlocks);
  const std::size_t patches = surface.patch_count();
  tbb::parallel_for(std::size_t{0}, kBlocks, [&](std::size_t b) {
    CellMaker maker(surface, deformation, along, smallest, blocks[b]);
    for (std::size_t p = patches * b / kBlocks; p < patches * (b + 1) / kBlocks; ++p)
      maker.add(static_cast<PatchId>(p));
  });
  return blocks;
}

}  // namespace tiltfeed
