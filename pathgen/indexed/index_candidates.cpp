#include "pathgen/indexed/index_candidates.h"

#include <array>
#include <cmath>
#include <map>

#include "pathgen/axis/direction_grid.h"

namespace tiltfeed::pathgen {

namespace {

/// Candidates are 16 degrees apart, or 8 where those do not reach what others do.
constexpr int kCoarseLevel = 2, kFineLevel = 3;
/// Planes of the part count as candidates of their own: at most this many, of at least this share of the
/// area.
constexpr std::size_t kMostPlanes = 24;
constexpr double kLeastPlane = 0.005;
/// Normals that agree to this are one plane's.
constexpr double kPlaneRounding = 1e-3;

/// The normals of the part's largest planes, the largest first.
std::vector<Vec3> plane_normals(const Mesh& mesh) {
  std::map<std::array<long long, 3>, Vec3> planes;  // the sum of area times normal
  double whole = 0.0;
  for (const auto& [i, j, k] : mesh.facets) {
    const Point<Part> a = mesh.vertices[i];
    const Vec3 twice = cross(mesh.vertices[j] - a, mesh.vertices[k] - a), n = normalized(twice);
    const auto round = [](double v) { return std::llround(v / kPlaneRounding); };
    Vec3& sum = planes[{round(n.x), round(n.y), round(n.z)}];
    sum = sum + twice, whole += length(twice);
  }
  std::vector<Vec3> found;
  for (const auto& [key, sum] : planes)
    if (length(sum) >= kLeastPlane * whole) found.push_back(sum);
  std::stable_sort(found.begin(), found.end(), [](Vec3 a, Vec3 b) { return length(a) > length(b); });
  if (found.size() > kMostPlanes) found.resize(kMostPlanes);
  for (Vec3& n : found) n = normalized(n);
  return found;
}

/// The directions a machinist would set first come first; then `count` of the grid from `first` on. Only
/// those within the tilt limit.
std::vector<Vec3> coarse_candidates(const CheckedMesh& part, const PlanOptions& options) {
  std::vector<Vec3> all{options.up};
  for (const Vec3 d :
       {Vec3{0, 0, 1}, Vec3{1, 0, 0}, Vec3{-1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, -1, 0}, Vec3{0, 0, -1}})
    all.push_back(d);
  for (const Vec3 n : plane_normals(part.mesh)) all.push_back(n);
  const DirectionGrid grid(kCoarseLevel);
  all.insert(all.end(), grid.directions().begin(), grid.directions().end());
  std::vector<Vec3> kept;
  for (const Vec3 d : all)
    if (angle_between(d, options.up) <= options.tilt_max.radians() &&
        std::none_of(kept.begin(), kept.end(), [d](Vec3 k) { return angle_between(d, k) < kPlaneRounding; }))
      kept.push_back(d);
  return kept;
}

}  // namespace

IndexCandidates index_candidates(const CheckedMesh& part, const PlanOptions& options, const CellReach& reach,
                                 const std::vector<SurfaceCell>& samples, const ReportShare& report) {
  IndexCandidates found{coarse_candidates(part, options), {}};
  found.sets = reach_sets(reach, samples, found.directions, part_of(report, 0.0, 0.4));
  std::vector<SurfaceCell> missed;
  for (std::size_t c = 0; c < samples.size(); ++c)
    if (!found.reach(c)) missed.push_back(samples[c]);
  const DirectionGrid grid(kFineLevel);
  const std::vector<Vec3> fine(grid.directions().begin() + DirectionGrid::count(kCoarseLevel),
                               grid.directions().end());
  const auto some = reach_sets(reach, missed, fine, part_of(report, 0.4, 0.7));
  std::vector<Vec3> useful;
  for (std::size_t d = 0; d < fine.size(); ++d)
    if (std::any_of(some[d].begin(), some[d].end(), [](std::uint8_t r) { return r != 0; }))
      useful.push_back(fine[d]);
  for (auto& set : reach_sets(reach, samples, useful, part_of(report, 0.7, 1.0)))
    found.sets.push_back(std::move(set));
  found.directions.insert(found.directions.end(), useful.begin(), useful.end());
  return found;
}

}  // namespace tiltfeed::pathgen
