#include "config/blank_of_job.h"

#include <algorithm>
#include <limits>
#include <memory>

#include "pathgen/mesh/stl.h"
#include "pathgen/tool/blank_solid.h"

namespace tiltfeed::config {
namespace {

/// A blank that is the very part may differ from it by rounding, mm.
constexpr double kSticksOut = 1e-3;

pathgen::BlankSolid box_round(const pathgen::Box& part, double margin) {
  const Vec3 by{margin, margin, margin};
  return pathgen::BlankSolid::box({part.min - by, part.max + by});
}

pathgen::BlankSolid bar_round(const pathgen::CheckedMesh& part, Vec3 up, double margin) {
  const Point<Part> middle = lerp(part.bounds.min, part.bounds.max, 0.5);
  double low = std::numeric_limits<double>::infinity(), high = -low, radius = 0.0;
  for (const Point<Part>& v : part.mesh.vertices) {
    const double h = dot(v - middle, up);
    low = std::min(low, h), high = std::max(high, h);
    radius = std::max(radius, length(v - middle - up * h));
  }
  return pathgen::BlankSolid::bar(middle + up * (low - margin), up, radius + margin,
                                  high - low + 2.0 * margin);
}

Result<pathgen::BlankSolid> blank_of_file(const Blank& blank, const pathgen::CheckedMesh& part) {
  const auto stl = pathgen::read_stl(blank.path, blank.unit_mm);
  if (!stl) return tl::unexpected(stl.error());
  auto shell = pathgen::check_mesh(*stl);
  if (!shell) return tl::unexpected(shell.error());
  if (shell->sides != pathgen::Sides::kOutward)
    return fail(Code::kMesh, "blank.file " + blank.path +
                                 " is not a closed surface, so what is inside it is not known; repair it");
  pathgen::BlankSolid solid = pathgen::BlankSolid::closed(std::move(shell->mesh));
  for (const Point<Part>& v : part.mesh.vertices)
    if (!solid.holds(v, kSticksOut))
      return fail(Code::kInput, "blank.file " + blank.path + " does not hold the part: its place " +
                                    to_string(v) + " is outside; is it in the part's coordinates and unit?");
  return solid;
}

}  // namespace

Result<void> add_blank(Job& job, const pathgen::CheckedMesh& part) {
  job.plan.blank = nullptr, job.plan.from_blank = false;
  if (!job.blank) return {};
  Result<pathgen::BlankSolid> solid =
      job.blank->shape == BlankShape::kFile ? blank_of_file(*job.blank, part)
      : job.blank->shape == BlankShape::kBox
          ? Result<pathgen::BlankSolid>(box_round(part.bounds, job.blank->margin))
          : Result<pathgen::BlankSolid>(bar_round(part, job.plan.up, job.blank->margin));
  if (!solid) return tl::unexpected(solid.error());
  job.plan.blank = std::make_shared<const pathgen::BlankSolid>(std::move(*solid));
  job.plan.from_blank = job.operation.number == 1;
  return {};
}

}  // namespace tiltfeed::config
