#pragma once
// A second reader of CAMWorks' APT text, by code of its own: the corners that the tool must pass, in order.
// It knows no pecks: they lie on the way from a hole's top to its bottom.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <istream>
#include <sstream>
#include <string>
#include <vector>

#include "kinematics/basics/geometry.h"
#include "kinematics/cl_text/apt_file.h"
#include "kinematics/joints/joint_path.h"

namespace tiltfeed {

struct Corner {
  Point<Part> tip;
  Vec3 axis;
  double feed = 0.0;  ///< mm/min of the way here; 0: rapid
};

class AptJudge {
 public:
  explicit AptJudge(std::istream& in) {
    for (std::string line; std::getline(in, line);) take(line);
  }
  const std::vector<Corner>& corners() const { return corners_; }

 private:
  static std::vector<double> numbers(const std::string& text) {
    std::vector<double> out;
    std::istringstream in(text);
    for (std::string one; std::getline(in, one, ',');) out.push_back(std::strtod(one.c_str(), nullptr));
    return out;
  }
  static double behind(const std::string& line, const std::string& word, double none) {
    const auto at = line.find("," + word + ",");
    return at == std::string::npos ? none : std::strtod(line.c_str() + at + word.size() + 2, nullptr);
  }
  void put(Vec3 tip, double feed) { corners_.push_back({{tip.x, tip.y, tip.z}, axis_, feed}); }
  Vec3 at() const { return from_origin(corners_.back().tip); }

  void take(const std::string& line) {
    const bool starts_cycle = line.rfind("CYCLE/D", 0) == 0;
    if (line.rfind("RAPID", 0) == 0) rapid_ = true;
    if (line.rfind("FEDRAT/", 0) == 0) feed_ = numbers(line.substr(7))[0];
    if (line.rfind("CIRCLE/", 0) == 0) circle_ = numbers(line.substr(7));
    if (line.rfind("LOAD/", 0) == 0) new_tool_ = true;
    if (line.rfind("CSYS/", 0) == 0) {
      const std::vector<double> v = numbers(line.substr(5));
      axis_ = {v[2], v[6], v[10]};
    }
    if (line.rfind("CYCLE/", 0) == 0) cycle_ = starts_cycle ? line : "";
    if (line.rfind("GOTO/", 0) == 0) go(numbers(line.substr(5)));
  }

  void go(const std::vector<double>& v) {
    if (v.size() == 6) axis_ = {v[3], v[4], v[5]};
    const Vec3 to{v[0], v[1], v[2]};
    if (!cycle_.empty()) {
      drill(to);
    } else if (!circle_.empty()) {
      turn(to);
    } else {
      put(to, rapid_ || new_tool_ ? 0.0 : feed_);
    }
    rapid_ = new_tool_ = false;
    circle_.clear();
  }
  void drill(Vec3 to) {
    const double depth = behind(cycle_, "FEDTO", 0), top = behind(cycle_, "RAPTO", 0),
                 back = behind(cycle_, "RTRCTO", top), feed = behind(cycle_, "MMPM", 0);
    const double height = dot(at() - to, axis_);
    if (height < back) put(at() + axis_ * (back - height), 0.0);
    put(to + axis_ * std::max(height, back), 0.0);
    put(to + axis_ * top, 0.0);
    put(to - axis_ * depth, feed);
    put(to + axis_ * back, 0.0);
  }
  /// Round the axis by the right hand, in steps of a fortieth of a degree at most.
  void turn(Vec3 to) {
    const Vec3 centre{circle_[0], circle_[1], circle_[2]}, n{circle_[3], circle_[4], circle_[5]};
    const Vec3 a = at() - centre, b = to - centre;
    double angle = std::atan2(dot(cross(a, b), n), dot(a, b));
    if (length(a - b) < 1e-6 || angle <= 0.0) angle += 2.0 * std::acos(-1.0);
    const int steps = 1 + static_cast<int>(angle * 57.3 * 40.0);
    for (int k = 1; k < steps; ++k) arc_.push_back(centre + rotation_about(n, angle * k / steps) * a);
    for (const Vec3& p : arc_) put(p, feed_);
    arc_.clear();
    put(to, feed_);
  }

  std::vector<Corner> corners_;
  std::vector<double> circle_;
  std::vector<Vec3> arc_;
  std::string cycle_;
  Vec3 axis_{0, 0, 1};
  double feed_ = 0.0;
  bool rapid_ = false, new_tool_ = false;
};

/// The program's polyline, walked once from corner to corner.
class WayOfProgram {
 public:
  WayOfProgram(const AptProgram& program, double tip, double axis_deg)
      : tip_(tip), axis_(axis_deg * std::acos(-1.0) / 180.0) {
    for (const AptOperation& op : program.operations)
      for (std::size_t i = 0; i < op.path.moves.size(); ++i) {
        const Move& move = op.path.moves[i];
        const bool rapid = move.kind == MoveKind::kRapid;
        points_.push_back({move.pose.tip, move.pose.axis, rapid ? 0.0 : feed_of(op.path, i).mm_per_min()});
      }
  }

  /// All of them, in order, and nothing else.
  void expect(const std::vector<Corner>& want) {
    ASSERT_FALSE(want.empty());
    for (std::size_t i = 0; i < want.size(); ++i) {
      SCOPED_TRACE("corner " + std::to_string(i));
      pass(want[i == 0 ? 0 : i - 1], want[i]);
      if (testing::Test::HasFatalFailure()) return;
    }
    for (std::size_t i = at_ + 1; i < points_.size(); ++i)
      EXPECT_LE(distance(points_[i].tip, want.back().tip), tip_);
  }

 private:
  /// The fraction from f_ on at which the way to the next point is nearest to `place`.
  double nearest(Point<Part> place) const {
    const Vec3 way = points_[at_ + 1].tip - points_[at_].tip;
    const double whole = squared_length(way);
    return whole > 0.0 ? std::clamp(dot(place - points_[at_].tip, way) / whole, f_, 1.0) : 1.0;
  }
  void pass(const Corner& from, const Corner& corner) {
    while (at_ + 1 < points_.size()) {
      const Corner &p = points_[at_], &q = points_[at_ + 1];
      const double f = nearest(corner.tip);
      if (distance(lerp(p.tip, q.tip, f), corner.tip) <= tip_) {
        EXPECT_LE(angle_between(slerp(p.axis, q.axis, f), corner.axis), axis_);
        f_ = f;
        return speeds(from, corner);
      }
      const double share = q.feed == 0.0 ? kRapidToleranceFactor : 1.0;
      ASSERT_LE(distance_to_segment(q.tip, from.tip, corner.tip), tip_ * share) << "point " << at_ + 1;
      ++at_;
      f_ = 0.0;
    }
    FAIL() << "the program ends before (" << corner.tip.x << ", " << corner.tip.y << ", " << corner.tip.z
           << ")";
  }
  /// Where the corner is no end of two ways at once.
  void speeds(const Corner& from, const Corner& corner) const {
    const Corner &p = points_[at_], &q = points_[at_ + 1];
    const double way = distance(p.tip, q.tip);
    const bool inside = f_ * way > 2.0 * tip_ && (1.0 - f_) * way > 2.0 * tip_;
    if (!inside && distance(from.tip, corner.tip) < 1.0) return;
    EXPECT_EQ(q.feed == 0.0, corner.feed == 0.0) << "rapid or feed, point " << at_ + 1;
    if (way > 1.0 && corner.feed > 0.0) {
      EXPECT_NEAR(q.feed / corner.feed, 1.0, 0.02) << "point " << at_ + 1;
    }
  }

  double tip_, axis_;
  std::vector<Corner> points_;
  std::size_t at_ = 0;
  double f_ = 0.0;
};

}  // namespace tiltfeed
