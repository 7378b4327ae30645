#include "daemon/post/part_extent.h"

#include <algorithm>
#include <limits>

namespace tiltfeed::daemon {
namespace {

/// Half the width of the tool at its widest, mm.
double half_width(const pathgen::Cutter& cutter) {
  double widest = std::max(cutter.cutting_top_radius(), cutter.shank_radius());
  for (const pathgen::HolderStep& step : cutter.holder)
    widest = std::max({widest, step.lower_diameter / 2.0, step.upper_diameter / 2.0});
  return widest;
}

}  // namespace

ClearSpace part_extent(const pathgen::Mesh& mesh, const config::Job& job) {
  const Vec3 up = rotary_up(job.machine.model, job.setup);
  const Vec3 to_part = transposed(job.setup.fixture) * job.setup.part_zero;
  double highest = -std::numeric_limits<double>::infinity(), furthest = 0.0;
  for (const Point<Part>& v : mesh.vertices) {
    const Vec3 from_zero = from_origin(v), from_axis = from_zero + to_part;
    highest = std::max(highest, dot(from_zero, up));
    furthest = std::max(furthest, length(from_axis - up * dot(from_axis, up)));
  }
  const double room = std::max(job.plan.allowance + job.plan.radial_stock + job.plan.axial_stock,
                               job.plan.fixtures ? job.plan.fixture_room.holder : 0.0) +
                      job.plan.links.clearance;
  return {highest + room, furthest + room + half_width(job.plan.cutter)};
}

}  // namespace tiltfeed::daemon
