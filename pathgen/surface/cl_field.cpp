#include "pathgen/surface/cl_field.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "pathgen/mesh/winding_number.h"
#include "pathgen/options/side_step.h"
#include "pathgen/progress/stages.h"
#include "pathgen/surface/exposed_backs.h"

namespace tiltfeed::pathgen {

namespace {

/// mm, and share of the side step.
constexpr double kSmallestCell = 0.1;
constexpr double kSmallestCellShare = 0.25;

constexpr std::size_t kFacetsPerBlock = 4096;
/// Of the work: until the hulls are made, and until it is known whether facets show their inside.
constexpr double kCellsShare = 0.4, kLookShare = 0.6;
/// Of the work with fixtures, the field without them.
constexpr double kPartShare = 0.5;

/// Of the facets that show their inside, so many are asked why.
constexpr std::size_t kFacetsAsked = 16;

tl::unexpected<Error> nothing_faces() {
  return fail(Code::kUnreachable,
              "no facet of the part faces the tool: check axis.sense, axis.origin_mm and axis.n");
}

/// R of the maths: the mean distance of the CL surface from the axis feature, over the facets that face the
/// tool.
double mean_rho(const Mesh& mesh, Sides sides, double offset, const AxisFrame& frame) {
  if (frame.mode == AxisMode::kFixed) return 1.0;
  const Deformation probe(frame, 1.0);
  struct Sum {
    double weight = 0.0, rho = 0.0;
  };
  // In blocks of fixed size, so that the sum is the same for any number of threads.
  std::vector<Sum> sums((mesh.facets.size() + kFacetsPerBlock - 1) / kFacetsPerBlock);
  tbb::parallel_for(std::size_t{0}, sums.size(), [&](std::size_t block) {
    const std::size_t end = std::min(mesh.facets.size(), (block + 1) * kFacetsPerBlock);
    Sum own;
    for (std::size_t i = block * kFacetsPerBlock; i < end; ++i) {
      const auto& f = mesh.facets[i];
      const Point<Part> a = mesh.vertices[f[0]], b = mesh.vertices[f[1]], c = mesh.vertices[f[2]];
      const Vec3 normal = cross(b - a, c - a);
      const double area = length(normal);
      const Point<Part> centre = lerp(lerp(a, b, 0.5), c, 1.0 / 3.0) + normal * (offset / area);
      const Deformation::Aim aim = probe.aim(centre);
      if (aim.away.rho <= 0.0) continue;
      if (sides == Sides::kOutward && dot(normal, aim.axis) <= 0.0) continue;
      own.weight += area, own.rho += area * aim.away.rho;
    }
    sums[block] = own;
  });
  double weight = 0.0, sum = 0.0;
  for (const Sum& s : sums) weight += s.weight, sum += s.rho;
  return weight > 0.0 ? sum / weight : 0.0;
}

/// Does the point, line or circle lie in the material above one of these facets?
bool feature_in_material(const Mesh& mesh, const Deformation& map, const std::vector<std::uint32_t>& facets) {
  const std::size_t stride = 1 + facets.size() / kFacetsAsked;
  for (std::size_t i = 0; i < facets.size(); i += stride)
    for (const std::uint32_t corner : mesh.facets[facets[i]]) {
      const auto& [a, b, c] = mesh.facets[facets[i]];
      const Point<Part> centre =
          lerp(lerp(mesh.vertices[a], mesh.vertices[b], 0.5), mesh.vertices[c], 1.0 / 3.0);
      const Point<Flat> flat = map.flatten(lerp(centre, mesh.vertices[corner], kBeside));
      const std::optional<Point<Part>> end = map.column_end(flat.x, flat.y);
      if (end && winding_number(mesh, *end) > 0.5) return true;
    }
  return false;
}

Result<std::unique_ptr<ClField>> field_of(const Mesh& mesh, Sides sides, const PlanOptions& options,
                                          const ReportShare& report) {
  std::vector<ToolPiece> pieces{tool_pieces(options).front()};
  const double scale = mean_rho(mesh, sides, pieces[0].corner, options.axis);
  if (scale <= 0.0) return nothing_faces();
  ClSurface surface(mesh, sides, std::move(pieces));
  const Deformation deformation(options.axis, scale);
  FlatHulls hulls = make_flat_hulls(surface, deformation, smallest_hull(options), report);
  if (report && !report(1.0)) return cancelled();
  if (hulls.hulls.empty()) return nothing_faces();
  FlatIndex index(std::move(hulls), deformation);
  const FlatBounds bounds = index.bounds();
  return std::make_unique<ClField>(ClField{std::move(surface), deformation, std::move(index), bounds});
}

Result<std::unique_ptr<const ClField>> field_of_part(const CheckedMesh& part, const PlanOptions& options,
                                                     std::vector<std::string>& warnings,
                                                     const ReportShare& report) {
  const ReportShare looking = part_of(report, kCellsShare, kLookShare),
                    again = part_of(report, kLookShare, 1.0);
  auto field = field_of(part.mesh, part.sides, options, part_of(report, 0.0, kCellsShare));
  if (!field || part.sides == Sides::kBoth) return field;
  const std::vector<std::uint32_t> backs = exposed_backs(
      (*field)->surface, (*field)->deformation, (*field)->index, reference_height(options.cutter), looking);
  if (looking && !looking(1.0)) return cancelled();
  const std::vector<std::uint32_t> folds =
      backs.empty() ? folded_facets(part.mesh, (*field)->surface.notches()) : std::vector<std::uint32_t>{};
  if (backs.empty() && folds.empty()) return field;
  const std::vector<std::uint32_t>& shown = backs.empty() ? folds : backs;
  const Point<Part> place = part.mesh.vertices[part.mesh.facets[shown.front()][0]];
  // Such a column ends where the tool comes from: at the feature, or at the axis of Theta.
  const AxisMode mode = options.axis.mode;
  const bool columns_end =
      mode == AxisMode::kCircle || (mode != AxisMode::kFixed && options.axis.sense == Sense::kInward);
  auto both = field_of(part.mesh, Sides::kBoth, options, again);
  if (both) (*both)->starts_inside = columns_end;
  if (columns_end && !backs.empty() && feature_in_material(part.mesh, (*field)->deformation, backs))
    return both;
  const char* what = backs.empty() ? " facets lie at narrow notches without material behind"
                                   : " facets show the tool their inside";
  const char* why =
      backs.empty() ? "the mesh is folded there and turned inside out" : "shells cross or fold there";
  warnings.push_back(std::to_string(shown.size()) + what + ", first facet " +
                     std::to_string(part.mesh.source[shown.front()]) + " at " + to_string(place) + ": " +
                     why + "; both sides of every facet count as surface, and the tool keeps off both");
  return both;
}

/// The field with the patches of fixtures, (C7): neither where the part is nor how it is flattened changes.
Result<std::unique_ptr<const ClField>> with_fixtures(const ClField& part, const PlanOptions& options,
                                                     const ReportShare& report) {
  const Mesh& own = part.surface.mesh();
  auto mesh = std::make_shared<const Mesh>(joined(own, options.fixtures->mesh));
  std::vector<ToolPiece> pieces = part.surface.pieces();
  for (const ToolPiece& piece : fixture_pieces(options)) pieces.push_back(piece);
  const bool both = part.surface.sides() == Sides::kBoth || options.fixtures->sides == Sides::kBoth;
  ClSurface surface(*mesh, both ? Sides::kBoth : Sides::kOutward, std::move(pieces), own.facets.size());
  FlatHulls hulls = make_flat_hulls(surface, part.deformation, smallest_hull(options), report);
  if (report && !report(1.0)) return cancelled();
  FlatIndex index(std::move(hulls), part.deformation);
  return std::make_unique<const ClField>(ClField{std::move(surface), part.deformation, std::move(index),
                                                 part.bounds, part.starts_inside, std::move(mesh)});
}

}  // namespace

double smallest_hull(const PlanOptions& options) {
  return std::max(kSmallestCell, kSmallestCellShare * asked_step(options));
}

Result<std::unique_ptr<const ClField>> make_field(const CheckedMesh& part, const PlanOptions& options,
                                                  std::vector<std::string>& warnings,
                                                  const ReportShare& report) {
  const double share = options.fixtures ? kPartShare : 1.0;
  auto field = field_of_part(part, options, warnings, part_of(report, 0.0, share));
  if (!field || !options.fixtures) return field;
  return with_fixtures(**field, options, part_of(report, share, 1.0));
}

}  // namespace tiltfeed::pathgen
