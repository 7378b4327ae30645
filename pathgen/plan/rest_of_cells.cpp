#include "pathgen/plan/rest_of_cells.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstdint>

#include "pathgen/indexed/indexed_cells.h"
#include "pathgen/options/side_step.h"
#include "pathgen/plan/between_passes.h"
#include "pathgen/tool/tool_pieces.h"

namespace tiltfeed::pathgen {

namespace {

/// Of more cells over the limit an even share is asked whether the tool reaches it.
constexpr std::size_t kMostAsked = 20'000;
/// Of the progress: measuring all cells, the rest for what is within reach.
constexpr double kMeasured = 0.5;

class Rest {
 public:
  Rest(const CheckedMesh& part, const PlanOptions& options, const SweptTool& tool,
       const std::vector<Vec3>& directions, const std::vector<Move>& path)
      : options_(options),
        piece_(tool_pieces(options).front()),
        moves_(path, piece_, reference_height(options.cutter),
               std::max(asked_step(options), options.pattern.step_down)),
        reach_(tool, options),
        directions_(directions),
        cells_(only_chosen(make_cells(part.mesh, std::max(piece_.outer, options.tolerance)), options)),
        left_(cells_.size(), 0.0) {
    report_.limit = asked_height(options) + options.tolerance;
  }

  BetweenPasses find(const ReportShare& report) {
    measure(part_of(report, 0.0, kMeasured));
    std::vector<std::uint32_t> over;
    double area = 0.0;
    for (std::uint32_t c = 0; c < cells_.size(); ++c)
      if (left_[c] > report_.limit)
        over.push_back(c), area += cells_[c].area;
      else
        take_worst(c);
    if (over.size() > kMostAsked) {
      const std::vector<std::uint32_t> all = std::move(over);
      over.resize(kMostAsked);
      for (std::size_t i = 0; i < kMostAsked; ++i) over[i] = all[i * all.size() / kMostAsked];
    }
    const std::vector<std::uint8_t> reached = reached_of(over, part_of(report, kMeasured, 1.0));
    double asked = 0.0;
    for (std::size_t i = 0; i < over.size(); ++i) {
      asked += cells_[over[i]].area;
      if (reached[i] == 0) continue;
      report_.area += cells_[over[i]].area;
      take_worst(over[i]);
    }
    if (asked > 0.0) report_.area *= area / asked;
    report_.never = report_.most >= moves_.farthest();
    report_.most = std::max(report_.most, kEnough * report_.limit);
    return report_;
  }

 private:
  Point<Part> touching(const SurfaceCell& cell) const { return cell.place + cell.normal * piece_.corner; }

  void measure(const ReportShare& report) {
    Watch watch(report, cells_.size());
    tbb::parallel_for(std::size_t{0}, cells_.size(), [&](std::size_t c) {
      if (watch.next()) left_[c] = moves_.left(cells_[c].place, touching(cells_[c]), kEnough * report_.limit);
    });
  }

  void take_worst(std::uint32_t c) {
    if (left_[c] <= report_.most) return;
    report_.most = left_[c], report_.facet = cells_[c].source, report_.place = cells_[c].place;
  }

  bool contains(Point<Part> reference) const {
    const Containment& in = options_.containment;
    return in.first.contains(reference.x) && in.second.contains(reference.y) &&
           in.height.contains(reference.z);
  }

  std::vector<std::uint8_t> reached_of(const std::vector<std::uint32_t>& over,
                                       const ReportShare& report) const {
    std::vector<std::uint8_t> reached(over.size(), 0);
    Watch watch(report, over.size());
    tbb::parallel_for(std::size_t{0}, over.size(), [&](std::size_t i) {
      const SurfaceCell& cell = cells_[over[i]];
      if (!watch.next() || !contains(touching(cell)) || !reach_.seats(cell)) return;
      std::uint32_t hint = kNoFacet;
      reached[i] = std::any_of(directions_.begin(), directions_.end(),
                               [&](Vec3 d) { return reach_.reaches(cell, d, hint); });
    });
    return reached;
  }

  const PlanOptions& options_;
  const ToolPiece piece_;
  CuttingMoves moves_;
  CellReach reach_;
  const std::vector<Vec3>& directions_;
  std::vector<SurfaceCell> cells_;
  std::vector<double> left_;  ///< by cell, mm
  BetweenPasses report_;
};

}  // namespace

BetweenPasses find_rest_of_cells(const CheckedMesh& part, const PlanOptions& options, const SweptTool& tool,
                                 const std::vector<Vec3>& directions, const std::vector<Move>& path,
                                 const ReportShare& report) {
  return Rest(part, options, tool, directions, path).find(report);
}

}  // namespace tiltfeed::pathgen
