#include "tests/attack/random_job.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "pathgen/axis/deformation.h"
#include "tests/attack/random_surroundings.h"
#include "tests/attack/written.h"

namespace tiltfeed::attack {
using namespace pathgen;
namespace {

/// The choices of a job one after the other; what is chosen first bounds what comes after.
class Writer {
 public:
  /// `larger`: so many times the cutter that is drawn.
  Writer(Dice& dice, const RandomPart& part, double larger = 1.0) : dice_(dice), part_(part) {
    const double turn = dice.unit();
    mode_ = turn < 0.15   ? AxisMode::kFixed
            : turn < 0.36 ? AxisMode::kPoint
            : turn < 0.62 ? AxisMode::kLine
            : turn < 0.82 ? AxisMode::kCircle
            : turn < 0.92 ? AxisMode::kFree
                          : AxisMode::kIndexed;
    diameter_ = part.size * dice.spread(0.012, 0.18) * larger;
    lean_dice_ = Dice(std::bit_cast<std::uint64_t>(diameter_));
    ridge_dice_ = Dice(~std::bit_cast<std::uint64_t>(diameter_));
    blank_dice_ = Dice(std::rotl(std::bit_cast<std::uint64_t>(diameter_), 32));
    more_dice_ = Dice(std::rotl(std::bit_cast<std::uint64_t>(diameter_), 16));
    tolerance_ = std::round(dice.spread(20, 500)) * 1e-4;
    tolerance_ = std::max(1e-4, std::min(tolerance_, std::floor(diameter_ * 0.05 * 1e4) * 1e-4));
    anchor_ = part.facets[dice.below(part.facets.size())][0];
    windowed_ = dice.chance(0.6);
    step_ = windowed_ ? diameter_ * dice.uniform(0.15, 1.2) : part.size * dice.uniform(0.06, 0.25);
  }

  std::string text(const std::string& name, const std::string& stl, const std::string& machine) {
    const double turn = more_dice_.unit();
    const std::size_t count = turn < 0.10 ? 2 : turn < 0.14 ? 3 : 1;
    std::string all;
    std::string own = sections();
    if (count > 1) own = "operations:\n" + listed("first", own + numbered(1)) + followers(count);
    if (more_dice_.chance(0.05)) all += std::string(kShortestTime) + "\n";
    all += "part: {name: " + name + ", stl: " + stl + ", unit: mm" + avoided() + "}\n" + own + setup_;
    if (blank_dice_.chance(kind_ == "rough" ? 0.7 : 0.3) && (is_field() || more_dice_.chance(0.7)))
      all +=
          formatted("blank: {shape: box, margin_mm: %.4f}\n", part_.size * blank_dice_.spread(0.002, 0.15));
    if (more_dice_.chance(0.15)) all += random_fixtures(more_dice_, part_);
    return all + "machine: " + machine + "\n";
  }

  /// What an operation states itself; sets setup_.
  std::string sections() {
    std::string all = cutter();
    all += axis();
    all += pattern();
    all += containment();
    all += formatted("tolerance_mm: %.4f\n", tolerance_);
    if (dice_.chance(0.25)) all += formatted("allowance_mm: %.4f\n", diameter_ * dice_.spread(0.002, 0.3));
    has_stock_ = dice_.chance(0.15);
    if (has_stock_) {
      const std::string stock =
          formatted("stock: {radial_mm: %.4f, axial_mm: %.4f}\n", diameter_ * dice_.uniform(0.0, 0.1),
                    diameter_ * dice_.uniform(0.0, 0.1));
      if (!ridge_) all += stock;
      has_stock_ = !ridge_;
    }
    all += points();
    all += guards();
    all += ends();
    return all;
  }

 private:
  bool is_free() const { return mode_ == AxisMode::kFree; }
  bool is_indexed() const { return mode_ == AxisMode::kIndexed; }
  bool is_field() const { return !is_free() && !is_indexed(); }

  std::string cutter() {
    const bool ball_only = !is_field();
    const char* type = dice_.one_of<const char*>({"ball", "ball", "bull_nose", "flat", "taper_ball"});
    if (ball_only) type = dice_.chance(0.75) ? "ball" : "taper_ball";
    const std::string kind = type;
    const double taper = dice_.spread(1.0, 20.0);
    const double cutting = std::max(diameter_ * dice_.uniform(1.0, 5.0), 0.2);
    const double shank = cutting + part_.size * dice_.spread(0.02, 1.2);
    const bool has_neck = dice_.chance(0.5);
    std::string t = "cutter:\n  type: " + kind + "\n" + formatted("  diameter_mm: %.5f\n", diameter_);
    if (kind == "bull_nose")
      t += formatted("  corner_radius_mm: %.5f\n", diameter_ * 0.5 * dice_.uniform(0.1, 0.9));
    if (kind == "taper_ball") t += formatted("  taper_deg: %.4f\n", taper);
    shank_length_ = shank;
    t += formatted("  length_mm: %.4f\n  shank_length_mm: %.4f\n", shank + 60.0, shank);
    if (has_neck) {
      const double top =
          kind == "taper_ball" ? diameter_ + 2.0 * cutting * std::tan(taper * kPi / 180.0) : diameter_;
      t += formatted("  cutting_length_mm: %.4f\n", cutting);
      t += formatted("  shank_diameter_mm: %.4f\n", top * dice_.uniform(0.6, 1.8));
    }
    has_holder_ = dice_.chance(0.35);
    if (has_holder_) {
      const double wide = std::max(diameter_ * dice_.uniform(1.2, 4.0), 1.0);
      t += "  holder:\n";
      t += formatted("    - {diameter_mm: %.4f, upper_diameter_mm: %.4f, length_mm: %.4f}\n", wide,
                     wide * dice_.uniform(0.8, 1.6), part_.size * dice_.uniform(0.05, 0.5));
      if (dice_.chance(0.5))
        t += formatted("    - {diameter_mm: %.4f, length_mm: %.4f}\n", wide * dice_.uniform(0.7, 2.0),
                       part_.size * dice_.uniform(0.05, 0.5));
    }
    has_neck_ = has_neck;
    is_ball_ = kind == "ball";
    ball_like_ = kind == "ball" || kind == "taper_ball";
    return t;
  }

  std::string axis() {
    if (is_free()) return free_axis();
    if (is_indexed()) return formatted("axis: {mode: indexed, most_directions: %zu}\n", 1 + dice_.below(4));
    const char* names[] = {"fixed", "point", "line", "circle"};
    const bool inward = mode_ != AxisMode::kFixed && dice_.chance(0.35);
    Vec3 t = dice_.chance(0.6) ? dice_.main_direction() : dice_.direction();
    Vec3 other = dice_.chance(0.6) ? dice_.main_direction() : dice_.direction();
    while (length(cross(t, other)) < 0.1) other = dice_.direction();
    const Vec3 n = normalized(other - t * dot(other, t));
    Point<Part> origin = part_.centre;
    const double where = dice_.unit();
    if (where < 0.25) {
      origin = part_.centre + dice_.direction() * (part_.size * dice_.uniform(0.0, 0.3));
    } else if (where < 0.6) {
      origin = part_.centre + dice_.direction() * (part_.size * dice_.uniform(0.3, 2.0));
    } else if (where < 0.7) {
      origin = part_.facets[dice_.below(part_.facets.size())][0];
    }
    const double radius = part_.size * dice_.spread(0.05, 1.5);
    frame_ = {mode_, inward ? Sense::kInward : Sense::kOutward, origin, t, n, radius};
    std::string text = std::string("axis:\n  mode: ") + names[static_cast<int>(mode_)] + "\n";
    if (mode_ != AxisMode::kFixed) text += std::string("  sense: ") + (inward ? "inward\n" : "outward\n");
    text += "  " + vector("origin_mm", from_origin(origin)) + "  " + vector("t", t) + "  " + vector("n", n);
    if (mode_ == AxisMode::kCircle) text += formatted("  circle_radius_mm: %.6f\n", radius);
    if (ball_like_ && lean_dice_.chance(0.5)) {
      leans_ = true;
      text += formatted("  lean_limit_deg: %.3f\n", lean_dice_.uniform(0.5, 60.0));
      if (lean_dice_.chance(0.3))
        text += formatted("  max_turn_deg_per_mm: %.3f\n", lean_dice_.spread(0.2, 60.0));
    }
    return text;
  }

  std::string free_axis() {
    std::string text = "axis:\n  mode: free\n  plane_normals: [";
    const std::size_t stacks = 1 + dice_.below(3);
    for (std::size_t i = 0; i < stacks; ++i) {
      const Vec3 d = dice_.chance(0.5) ? dice_.main_direction() : dice_.direction();
      text += (i > 0 ? ", [" : "[") + formatted("%.6f, %.6f, %.6f]", d.x, d.y, d.z);
    }
    text += "]\n";
    if (dice_.chance(0.4)) text += formatted("  lead_deg: %.3f\n", dice_.uniform(-40.0, 40.0));
    if (dice_.chance(0.4)) text += formatted("  lean_deg: %.3f\n", dice_.uniform(-40.0, 40.0));
    return text;
  }

  std::string pattern() {
    kind_ = "raster";
    if (is_indexed()) kind_ = dice_.one_of<const char*>({"raster", "raster", "z_level", "split"});
    if (is_field()) {
      const double turn = dice_.unit();
      kind_ = turn < 0.62   ? "raster"
              : turn < 0.72 ? "z_level"
              : turn < 0.82 ? "split"
              : turn < 0.88 ? "rough"
              : turn < 0.94 ? "contour"
                            : "spiral";
    }
    if (!is_free() && kind_ == "raster" && more_dice_.chance(0.08)) {
      kind_ = "pencil";
      return "pattern:\n  kind: pencil\n" +
             (more_dice_.chance(0.5) ? formatted("  crease_angle_deg: %.3f\n", more_dice_.uniform(2.0, 40.0))
                                     : std::string());
    }
    if (kind_ == "contour" || kind_ == "spiral")
      windowed_ = true, step_ = diameter_ * dice_.uniform(0.4, 1.2);
    const bool lines = kind_ == "raster" || kind_ == "split" || kind_ == "rough";
    std::string text = "pattern:\n  kind: " + kind_ + "\n";
    if (lines && !is_free()) {
      text += std::string("  along: ") + dice_.one_of<const char*>({"x", "y"}) + "\n";
      if (dice_.chance(0.2)) text += formatted("  angle_deg: %.3f\n", dice_.uniform(-180.0, 180.0));
    }
    if (lines) text += std::string("  direction: ") + (dice_.chance(0.7) ? "zigzag\n" : "one_way\n");
    if (kind_ != "z_level" && !is_free()) {
      const double turn = dice_.unit();
      const char* measure = turn < 0.6 ? "flat" : turn < 0.8 || kind_ == "rough" ? "surface" : "scallop";
      ridge_ = is_field() && kind_ == "raster" && is_ball_ && turn < 0.6 && ridge_dice_.chance(0.4);
      if (ridge_) measure = "ridge";
      text += std::string("  measure: ") + measure + "\n";
      if (*measure == 's' && measure[1] == 'c')
        text += formatted("  scallop_mm: %.5f\n", diameter_ * dice_.spread(0.01, 0.045));
    }
    if (kind_ != "z_level") text += formatted("  side_step_mm: %.5f\n", step_);
    if (kind_ == "z_level" || kind_ == "split" || kind_ == "rough")
      text += formatted("  step_down_mm: %.5f\n", step_ * dice_.uniform(0.7, 2.0));
    if (kind_ == "z_level" && dice_.chance(0.3)) text += "  milling: conventional\n";
    return text;
  }

  /// A few steps round a place of the part, in the coordinates of the axis mode.
  std::string containment() {
    std::string text = window();
    if (kind_ == "rough" || kind_ == "pencil" || !more_dice_.chance(0.12)) return text;
    return (text.empty() ? "containment:\n" : text) + "  faces: [" + named_ball(more_dice_, part_) + "]\n";
  }
  std::string window() {
    if (!windowed_) return "";
    const double half = step_ * dice_.uniform(1.5, 5.0), other = half * dice_.uniform(0.6, 3.0);
    std::string text = "containment:\n";
    if (!is_field()) {
      for (int i = 0; i < 3; ++i) {
        const double at = i == 0 ? anchor_.x : i == 1 ? anchor_.y : anchor_.z;
        const char* keys[] = {"x_mm", "y_mm", "z_mm"};
        const double room = std::max(i == 0 ? other : half, diameter_);
        text += interval(keys[i], at - room, at + room);
      }
      return text;
    }
    const Deformation map(frame_, 1.0);
    const Point<Flat> flat = map.flatten(anchor_);
    const double degree = 180.0 / kPi, rho = std::max(std::abs(flat.z), 1e-3);
    std::array<double, 4> box{};  // first low and high, second low and high
    const auto turns = [&](std::size_t i, double middle, double room, double most) {
      const double by = std::min(room / rho * degree, 0.9 * most);
      box[i] = std::clamp(middle * degree - by, -most, most),
      box[i + 1] = std::clamp(middle * degree + by, -most, most);
    };
    const auto lengths = [&](std::size_t i, double middle, double room) {
      box[i] = middle - room, box[i + 1] = middle + room;
    };
    const char *first = "theta_deg", *second = "phi_deg";
    if (mode_ == AxisMode::kPoint) {
      turns(0, flat.x, other / std::max(0.05, std::cos(flat.y)), 180.0), turns(2, flat.y, half, 90.0);
    } else if (mode_ == AxisMode::kCircle) {
      const double around = std::max(0.05 * rho, frame_.circle_radius + rho * std::cos(flat.y));
      turns(0, flat.x / (frame_.circle_radius + 1.0), other * rho / around, 180.0),
          turns(2, flat.y, half, 180.0);
    } else if (mode_ == AxisMode::kLine) {
      first = "x_mm", second = "theta_deg";
      lengths(0, flat.x, other), turns(2, flat.y, half, 180.0);
    } else {
      first = "x_mm", second = "y_mm";
      lengths(0, flat.x, other), lengths(2, flat.y, half);
    }
    if (kind_ == "contour" || kind_ == "spiral") {
      text += formatted("  boundary: [[%.6f, %.6f], [%.6f, %.6f], [%.6f, %.6f], [%.6f, %.6f]]\n", box[0],
                        box[2], box[1], box[2], box[1], box[3], box[0], box[3]);
    } else {
      text += interval(first, box[0], box[1]) + interval(second, box[2], box[3]);
    }
    if (dice_.chance(0.25)) {
      const bool is_fixed = mode_ == AxisMode::kFixed;
      const double low = std::abs(flat.z) - diameter_ * dice_.uniform(0.0, 3.0);
      text += interval(is_fixed ? "z_mm" : "rho_mm", is_fixed ? flat.z - diameter_ : std::max(0.0, low),
                       (is_fixed ? flat.z : rho) + diameter_ * dice_.uniform(0.5, 3.0));
    }
    return text;
  }

  std::string points() {
    std::string text;
    if (dice_.chance(0.1))
      text += formatted("  max_distance_mm: %.4f\n", diameter_ * dice_.uniform(0.1, 1.0));
    if (dice_.chance(0.1)) text += formatted("  max_angle_deg: %.4f\n", dice_.uniform(0.5, 10.0));
    if (is_field() && kind_ != "z_level" && kind_ != "rough" && dice_.chance(0.1)) {
      const double radius = diameter_ * dice_.uniform(0.1, 1.0);
      if (!ridge_) text += formatted("  smoothing_mm: %.4f\n", radius);
    }
    if ((is_free() || (is_field() && mode_ != AxisMode::kFixed)) && ball_like_ && dice_.chance(0.1)) {
      const double leans = dice_.uniform(0.1, 8.0);
      if (!has_stock_) text += formatted("  axis_tolerance_deg: %.3f\n", leans);
    }
    return text.empty() ? text : "points:\n" + text;
  }

  std::string guard(const char* which) {
    const char* reaction = dice_.one_of<const char*>({"trim", "trim", "retract"});
    if (!is_field()) reaction = "trim";
    if (leans_ && !has_stock_) reaction = lean_dice_.one_of<const char*>({"tilt", "tilt", "tilt", "trim"});
    return formatted("  %s: {clearance_mm: %.4f, reaction: %s}\n", which, diameter_ * dice_.uniform(0.0, 0.4),
                     reaction);
  }
  std::string guards() {
    std::string text;
    if (has_neck_ && dice_.chance(0.4)) text += guard("shank");
    if (has_holder_ && dice_.chance(0.6)) text += guard("holder");
    return text.empty() ? text : "guards:\n" + text;
  }

  static std::string numbered(std::size_t tool) { return "program: {tool: " + std::to_string(tool) + "}\n"; }
  /// A section of text as an item of a list.
  static std::string listed(const std::string& name, const std::string& text) {
    std::string all = "  - name: " + name + "\n    ";
    for (const char c : text.substr(0, text.size() - 1)) all += c == '\n' ? "\n    " : std::string(1, c);
    return all + "\n";
  }

  /// The operations behind the first, each with sections of its own. Some cut only what is left.
  std::string followers(std::size_t count) {
    std::string all;
    for (std::size_t i = 1; i < count; ++i) {
      Dice own(more_dice_.bits());
      Writer next(own, part_, more_dice_.uniform(0.3, 1.0));
      std::string text = next.sections();
      if (!next.is_free() && more_dice_.chance(0.5))
        text += formatted("rest: {more_than_mm: %.4f}\n",
                          std::max(0.01, 2.0 * next.tolerance_ + diameter_ * more_dice_.spread(0.005, 0.2)));
      all += listed("next " + std::to_string(i), text + numbered(i + 1));
    }
    return all;
  }

  std::string avoided() {
    if (!more_dice_.chance(0.12)) return "";
    return ", avoid_faces: [" + named_ball(more_dice_, part_) + "]" +
           formatted(", avoid_mm: %.4f", std::max(0.001, diameter_ * more_dice_.spread(0.01, 0.5)));
  }

  /// Links, feeds and how the part sits.
  std::string ends() {
    std::string text;
    if (dice_.chance(0.3)) {
      text += formatted("links: {join_distance_mm: %.4f",
                        dice_.chance(0.3) ? 0.0 : step_ * dice_.spread(0.5, 20.0));
      if (!is_free() && dice_.chance(0.4))
        text += formatted(", lead_radius_mm: %.4f", diameter_ * dice_.uniform(0.1, 2.0));
      text += "}\n";
    }
    const double clearance = std::max(0.05, part_.size * dice_.spread(0.01, 0.3));
    text +=
        formatted("clearance_mm: %.4f\napproach_mm: %.4f\n", clearance, clearance * dice_.uniform(0.1, 1.0));
    text += "feeds: {cut_mm_per_min: 2000, plunge_mm_per_min: 600}\n";
    setup_ = "setup:\n  part_zero_mm: [0, 0, 300]\n";
    if (dice_.chance(0.4))
      setup_ += formatted("  fixture_rotation_deg: [%.3f, %.3f, %.3f]\n", dice_.uniform(-180.0, 180.0),
                          dice_.chance(0.5) ? 90.0 : 0.0, dice_.uniform(-90.0, 90.0));
    if (dice_.chance(0.4)) setup_ += formatted("  tilt_max_deg: %.3f\n", dice_.uniform(40.0, 175.0));
    return text;
  }

  Dice& dice_;
  const RandomPart& part_;
  AxisMode mode_ = AxisMode::kFixed;
  AxisFrame frame_;
  std::string kind_, setup_;
  Point<Part> anchor_;
  double diameter_ = 0.0, tolerance_ = 0.0, step_ = 0.0, shank_length_ = 0.0;
  Dice lean_dice_{0}, ridge_dice_{0}, blank_dice_{0},
      more_dice_{0};  ///< of their own, so that all else is chosen as it was
  bool leans_ = false, ridge_ = false, is_ball_ = false, windowed_ = false, has_holder_ = false,
       has_neck_ = false, ball_like_ = false, has_stock_ = false;
};

}  // namespace

std::string random_job(Dice& dice, const RandomPart& part, const std::string& name, const std::string& stl,
                       const std::string& machine) {
  return Writer(dice, part).text(name, stl, machine);
}

}  // namespace tiltfeed::attack
