#pragma once
// The part as it is asked, again and again, what a tool reaches of it with another axis, tilt or set-up: for
// suggestions and for who drags an axis on a screen. (X1)..(X3) in pathgen/reach/README.md.

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "pathgen/mesh/mesh.h"
#include "pathgen/options/plan_options.h"
#include "pathgen/reach/machine_reach.h"
#include "pathgen/reach/reach.h"

namespace tiltfeed::pathgen {

/// A place of the surface that stands for an area.
struct ReachPlace {
  Point<Part> place;
  Vec3 normal;              ///< unit
  double area = 0.0;        ///< mm^2
  std::uint32_t facet = 0;  ///< of the mesh
  bool fits = true;         ///< the rounded end of the cutter does there
};

struct ReachQuestion {
  AxisFrame axis;
  std::vector<Vec3> directions;  ///< with AxisMode::kIndexed; with kFree the only ones that are tried besides
                                 ///< the normal, empty: an even grid
  Vec3 up{0, 0, 1};              ///< as PlanOptions::up
  Angle tilt_max = Angle::from_degrees(180.0);
  const MachineReach* machine = nullptr;  ///< null: its limits are not asked
  /// The machine must reach the place drawn back, too: in outward work so far over all that the part's box
  /// has, mm, along the axis; nothing: that is not asked.
  std::optional<double> clearance;
};

/// By how much the tool is drawn back as a question's `clearance` asks.
class DrawnBack {
 public:
  /// `box`: of the part. `question` must outlive the object.
  DrawnBack(const ReachQuestion& question, const Box& box);
  /// mm; 0: not at all.
  double operator()(Point<Part> reference, Vec3 axis) const;

 private:
  const ReachQuestion& question_;
  std::optional<Deformation> map_;        ///< of a predefined axis
  std::array<Point<Part>, 8> corners_{};  ///< of the box
  double top_ = 0.0;                      ///< z' of the highest of them
};

/// What is looked along the tool's axis for what is in its way.
enum class Rays {
  kAxis,  ///< one ray, the axis itself: for a picture while something moves
  kRim,   ///< six more round each width of the tool
};

class ReachScene {
 public:
  /// `part` must outlive the object; of `tool` the cutter, stock and guards are taken.
  ReachScene(const CheckedMesh& part, const PlanOptions& tool);
  ~ReachScene();
  ReachScene(const ReachScene&) = delete;
  ReachScene& operator=(const ReachScene&) = delete;

  /// The middle of every facet, in the mesh's order. Asks once for each whether the cutter fits: make it once
  /// and keep it.
  std::vector<ReachPlace> facets() const;
  /// About `count` places of equal area, spread evenly.
  std::vector<ReachPlace> sample(std::size_t count) const;

  /// (X1)..(X3) In parallel; the same for any number of threads. The places are this part's. May be asked
  /// from several threads.
  ReachMap ask(const ReachQuestion& question, std::span<const ReachPlace> places, Rays rays) const;

 private:
  struct Parts;
  std::unique_ptr<const Parts> parts_;
};

}  // namespace tiltfeed::pathgen
