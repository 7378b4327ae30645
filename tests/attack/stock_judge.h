#pragma once
// Rapids against the blank that a job states, by brute force: places in the cutter are asked one by one
// whether any move before has cut them. Shares nothing with the planner's stock.

#include <cstddef>
#include <optional>
#include <vector>

#include "config/job.h"
#include "kinematics/basics/tool_path.h"
#include "pathgen/mesh/mesh_check.h"
#include "sim/solid/tool_solid.h"

namespace tiltfeed::attack {
using namespace pathgen;
using namespace config;

/// Of the first operation of a job whose blank is a box.
class StockJudge {
 public:
  static bool can_judge(const Job& job);

  /// All must outlive the judge. `executed`: what the machine makes of the path.
  StockJudge(const Job& job, const CheckedMesh& part, const ToolPath& executed);

  struct Found {
    std::size_t places = 0;    ///< in the blank and in the cutter on a rapid
    std::optional<Pose> pose;  ///< of a rapid that runs into stock
    Point<Part> at;
    double depth = 0.0;  ///< of the place in the cutter, at least, mm
  };
  /// Looks at so many rapids at most.
  Found look(std::size_t rapids) const;

 private:
  bool in_blank(Point<Part> p) const;
  bool is_cut(Point<Part> p, std::size_t before) const;
  double off_cutter(Point<Part> p, const Pose& pose) const;

  const Job& job_;
  const ToolPath& path_;
  sim::ToolSolid tool_;
  Box blank_;
  double depth_;  ///< asked for, mm
};

}  // namespace tiltfeed::attack
