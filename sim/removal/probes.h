#pragma once
// How much is left on the part: points all over its surface, each with a line along the facet's normal, cut
// off exactly where the tool enters it. The value of a probe is the least over all that the tool did, so it
// depends on no order. Formula (W5) is in sim/removal/README.md.

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "pathgen/mesh/mesh.h"
#include "sim/removal/swept_body.h"
#include "sim/solid/distance.h"

namespace tiltfeed::sim {

/// Facets cut up until none holds many probes: what is coloured as one.
struct Patches {
  pathgen::Mesh mesh;                ///< source: facet of the STL file
  std::vector<std::uint64_t> first;  ///< of its probes; one more than patches
  std::vector<float> radius;         ///< of the circle about its corners' mean, mm
  std::vector<Point<Part>> middle;
  std::vector<Vec3> normal;
};

/// Of each probe.
inline constexpr std::size_t kProbeBytes = 8;
// Bounds are this much wider than they need be, mm: far above what rounding takes from them.
inline constexpr double kBoundSlack = 1e-9;

/// The way of a ball's centre, straight.
struct BallWay {
  Point<Part> from;
  Vec3 unit;  ///< zero if it stands
  double whole = 0.0, radius = 0.0;

  BallWay(Point<Part> start, Point<Part> end, double ball)
      : from(start), whole(tiltfeed::distance(start, end)), radius(ball) {
    if (whole > 0.0) unit = (end - start) / whole;
  }
  double distance(Point<Part> p) const {
    const Vec3 m = p - from;
    return length(m - unit * std::clamp(dot(m, unit), 0.0, whole));
  }
};

/// Not more than any value that the ball can leave on a flat patch round `middle`, mm.
double least_left(const BallWay& way, Point<Part> middle, Vec3 normal, double radius);

class Probes {
 public:
  static constexpr std::uint32_t kNever = 0xFFFFFFFF;

  /// One probe for each square of `spacing`, at least one a facet; `reach`: more than that is not told apart.
  Probes(const pathgen::Mesh& part, double spacing, double reach);

  /// A probe at hand.
  struct Live {
    Point<Part> place;
    std::uint64_t probe = 0;
    double left = 0.0;   ///< Value::left, or what it was a moment ago
    double bound = 0.0;  ///< not less than any value that would change it, mm
  };
  /// Appends the probes of a patch.
  void collect(std::uint32_t patch, std::vector<Live>& live) const;
  /// The tool's cutting part passes probes of a patch: body(p) is its piece near p, least(p) not more than
  /// what it can leave there, or below 0 if p may be inside. `move` is what the probes remember. The largest
  /// of their bounds. Thread-safe.
  template <class Body, class Least>
  double pass(std::uint32_t patch, double radius, std::uint32_t move, std::span<Live> live, const Body& body,
              const Least& least);
  /// PartDistance::descend() over the patches in the boxes of which reaches(low, high, most, which) is not 0;
  /// most: not less than highest() of any patch inside. Thread-safe.
  template <class Reaches, class Visit>
  void search(std::uint32_t which, const Reaches& reaches, const Visit& visit);
  /// The same as pass() for a ball.
  double pass_ball(std::uint32_t patch, const BallWay& way, std::uint32_t move, std::span<Live> live);
  /// Makes highest() anew; call after passing.
  void settle(std::uint32_t patch);
  /// Not less than any value of the patch's probes, mm.
  double highest(std::uint32_t patch) const {
    return static_cast<double>(
        std::atomic_ref<float>(const_cast<float&>(highest_[patch])).load(std::memory_order_relaxed));
  }

  struct Value {
    double left = 0.0;            ///< material left along the normal, mm; below 0: cut into the part
    std::uint32_t move = kNever;  ///< that left it; kNever: the tool never came within reach
  };
  Value value(std::uint64_t probe) const;
  Point<Part> place(std::uint32_t patch, std::uint64_t probe) const;
  const Patches& patches() const { return patches_; }
  const PartDistance& surface() const { return surface_; }
  std::uint64_t count() const { return patches_.first.back(); }
  double patch_area(std::uint32_t patch) const;
  double reach() const { return reach_; }
  double spacing() const { return spacing_; }
  std::size_t bytes() const;

 private:
  /// Would a probe of which `left` is left, a float's value, be lowered or its move be an earlier one?
  bool takes(double enter, double left) const {
    return enter < reach_ && static_cast<double>(static_cast<float>(enter)) <= left;
  }
  void take(std::uint64_t probe, double left, std::uint32_t move);
  /// What would change a probe with so much left is not more than this.
  double bound(double left) const { return std::min(reach_, left) + kBoundSlack; }

  double spacing_, reach_;
  Patches patches_;
  std::vector<std::array<double, 2>> spread_;  ///< of the probes on a patch, in order
  PartDistance surface_;                       ///< of the patches
  /// The value's bits, ordered like the value, above the move: the least of these numbers is the least value,
  /// of the earliest move.
  std::vector<std::uint64_t> values_;
  std::vector<float> highest_;  ///< by patch: bounds that are made anew when its probes are looked at
  std::vector<float> boxes_;    ///< by box of surface_: bounds of highest_ inside
};

template <class Reaches, class Visit>
void Probes::search(std::uint32_t which, const Reaches& reaches, const Visit& visit) {
  surface_.descend(boxes_, which, reaches, [&](std::uint32_t patch, std::uint32_t left) {
    visit(patch, left);
    return std::atomic_ref<float>(highest_[patch]).load(std::memory_order_relaxed);
  });
}

template <class Body, class Least>
double Probes::pass(std::uint32_t patch, double radius, std::uint32_t move, std::span<Live> live,
                    const Body& body, const Least& least) {
  std::optional<SweptBody> swept;
  std::optional<LineCutter> cutter;
  double most = -kInfinity;
  for (Live& l : live) {
    if (least(l.place) <= l.bound) {
      if (!cutter) swept = body(patches_.middle[patch]), cutter.emplace(*swept, patches_.normal[patch]);
      const auto inside = (*cutter)(l.place, -radius, reach_);
      if (inside && inside->leave > 0.0 && takes(inside->enter, l.left) &&
          !swept->leaves_to_ball(l.place + patches_.normal[patch] * std::max(0.0, inside->enter))) {
        const double depth = inside->enter < 0.0 ? std::max(0.0, swept->depth(l.place)) : 0.0;
        l.left = std::min(l.left, std::max(inside->enter, -depth)), l.bound = bound(l.left);
        take(l.probe, l.left, move);
      }
    }
    most = std::max(most, l.bound);
  }
  return most;
}

}  // namespace tiltfeed::sim
