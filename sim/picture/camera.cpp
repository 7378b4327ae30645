#include "sim/picture/camera.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tiltfeed::sim {
namespace {

constexpr double kEyeDistance = 5.0;  // in radii of the scene
constexpr double kElevation = 0.98;   // rad above the plane across the mean tool axis
constexpr double kAzimuth = 0.40;     // rad off the part's long side, so that two sides are seen
constexpr double kLeanAlong = 0.42;   // rad towards the axis that an all-round path runs about
constexpr double kRoll = -0.25;       // rad; an all-round part lies slanting in the picture
constexpr double kMargin = 0.06;      // of the picture, on each side
// Below this mean the tool comes from all round and the mean says nothing.
constexpr double kAllRound = 0.35;
constexpr int kPowerSteps = 300;

struct Moments {
  Vec3 xx, yy, zz;  // rows of the matrix of second moments
  void add(Vec3 v, double weight) {
    xx = xx + v * (v.x * weight), yy = yy + v * (v.y * weight), zz = zz + v * (v.z * weight);
  }
  Vec3 operator*(Vec3 v) const { return {dot(xx, v), dot(yy, v), dot(zz, v)}; }
  double trace() const { return xx.x + yy.y + zz.z; }
};

/// The direction in which the moments are largest (or smallest), by repeated multiplication; its largest
/// component is positive.
Vec3 principal(const Moments& m, bool smallest) {
  Vec3 v = normalized({1.0, 0.7, 0.4});
  for (int i = 0; i < kPowerSteps; ++i) {
    const Vec3 next = smallest ? v * m.trace() - m * v : m * v;
    if (squared_length(next) <= 0.0) break;
    v = normalized(next);
  }
  const double most = std::abs(v.x) >= std::abs(v.y) && std::abs(v.x) >= std::abs(v.z) ? v.x
                      : std::abs(v.y) >= std::abs(v.z)                                 ? v.y
                                                                                       : v.z;
  return most < 0.0 ? -v : v;
}

Vec3 any_across(Vec3 v) { return normalized(cross(v, std::abs(v.z) < 0.9 ? Vec3{0, 0, 1} : Vec3{1, 0, 0})); }

}  // namespace

Camera::Camera(const pathgen::Mesh& part, const ToolPath& path, int width, int height) {
  Vec3 low = from_origin(part.vertices[0]), high = low;
  for (const Point<Part> p : part.vertices) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  centre_ = Point<Part>{} + (low + high) * 0.5;
  radius_ = std::max(0.5 * length(high - low), 1e-6);
  far_ = kEyeDistance * radius_;
  aim(part, path);
  fit(part, path, width, height);
}

void Camera::aim(const pathgen::Mesh& part, const ToolPath& path) {
  const auto each_axis = [&](const auto& visit) {
    for (const Move& move : path.moves)
      if (move.kind == MoveKind::kCut) visit(move.pose.axis);
  };
  Vec3 sum;
  double count = 0.0;
  each_axis([&](Vec3 axis) { sum = sum + axis, count += 1.0; });
  const Vec3 mean = count > 0.0 ? sum / count : Vec3{0, 0, 1};
  if (length(mean) >= kAllRound) {
    const Vec3 m = normalized(mean);
    Moments spread;
    for (const Point<Part> p : part.vertices) {
      const Vec3 v = p - centre_;
      spread.add(v - m * dot(v, m), 1.0);
    }
    Vec3 side = principal(spread, false);
    side = side - m * dot(side, m);
    side = squared_length(side) > 1e-12 ? normalized(side) : any_across(m);
    const Vec3 towards = rotation_about(m, -kAzimuth) * cross(side, m);
    eye_ = m * std::sin(kElevation) + towards * std::cos(kElevation);
    right_ = normalized(cross(m, eye_));
  } else {
    Moments axes;
    each_axis([&](Vec3 axis) { axes.add(axis, 1.0); });
    const Vec3 about = principal(axes, true);
    Vec3 front = mean - about * dot(mean, about);
    front = squared_length(front) > 1e-4 ? normalized(front) : any_across(about);
    eye_ = front * std::cos(kLeanAlong) + about * std::sin(kLeanAlong);
    right_ = normalized(about - eye_ * dot(about, eye_));
    right_ = rotation_about(eye_, kRoll) * right_;
    if (cross(eye_, right_).z < 0.0) right_ = -right_;  // what is up stays up
  }
  up_ = cross(eye_, right_);
}

void Camera::fit(const pathgen::Mesh& part, const ToolPath& path, int width, int height) {
  scale_ = 1.0;
  constexpr double kNone = std::numeric_limits<double>::infinity();
  double x0 = kNone, x1 = -kNone, y0 = kNone, y1 = -kNone;
  const auto add = [&](Point<Part> p) {
    const ScreenPoint s = project(p);
    x0 = std::min(x0, s.x), x1 = std::max(x1, s.x), y0 = std::min(y0, s.y), y1 = std::max(y1, s.y);
  };
  for (const Point<Part> p : part.vertices) add(p);
  for (const Move& move : path.moves)
    if (move.kind == MoveKind::kCut) add(move.pose.tip);
  const double room = 1.0 - 2.0 * kMargin;
  scale_ = std::min(width * room / std::max(x1 - x0, 1e-9), height * room / std::max(y1 - y0, 1e-9));
  shift_x_ = width / 2.0 - scale_ * (x0 + x1) / 2.0;
  shift_y_ = height / 2.0 - scale_ * (y0 + y1) / 2.0;
}

ScreenPoint Camera::project(Point<Part> p) const {
  const Vec3 v = p - centre_;
  const double away = std::max(far_ - dot(v, eye_), 0.01 * far_), k = scale_ / away;
  // -1/away is linear over the screen; scaled to mm at the scene's centre.
  return {shift_x_ + dot(v, right_) * k, shift_y_ - dot(v, up_) * k, far_ - far_ * far_ / away};
}

Vec3 Camera::view_from(Point<Part> p) const { return normalized(centre_ + eye_ * far_ - p); }

}  // namespace tiltfeed::sim
