#include "pathgen/plan/rest_wanted.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "pathgen/indexed/indexed_cells.h"
#include "pathgen/mesh/mesh.h"
#include "pathgen/options/side_step.h"
#include "pathgen/plan/between_passes.h"
#include "pathgen/progress/stages.h"
#include "pathgen/tool/contact_line.h"

namespace tiltfeed::pathgen {

namespace {

/// Of the smallest radius: the size of the part's cells.
constexpr double kCellShare = 1.0 / 3.0;
/// Of what may be left: what a pose must take of a cell.
constexpr double kGain = 0.5;
/// Of the cutter's radius: what never was near to the tool is no reason for a pose further away.
constexpr double kNearRest = 0.5;
/// What leans over by less (sine) than 15 degrees rows do not follow: walls are z_level's, down to rounding.
constexpr double kRestFacing = 0.2588190451025208, kWallFacing = 1e-3;
/// Of a cube's index.
constexpr std::int64_t kIndexBits = 21;

std::shared_ptr<const PlanOptions> bare_options(const PlanOptions& options) {
  auto bare = std::make_shared<PlanOptions>(options);
  bare->allowance = bare->radial_stock = bare->axial_stock = 0.0;
  return bare;
}

/// What one operation leaves at places of the part.
class LeftBy {
 public:
  explicit LeftBy(const EarlierCut& cut)
      : bare_(bare_options(cut.options)),
        piece_(tool_pieces(*bare_).front()),
        moves_(cut.moves, piece_, reference_height(cut.options.cutter),
               std::max({asked_step(cut.options), cut.options.pattern.step_down, 0.1 * piece_.outer})) {
    const AxisMode mode = cut.options.axis.mode;
    if (mode != AxisMode::kFree && mode != AxisMode::kIndexed) field_.emplace(cut.options.axis, 1.0);
  }
  double farthest() const { return moves_.farthest(); }
  double at(Point<Part> place, Vec3 normal, double enough) const {
    // Without a field of axes the cutter ends in a ball.
    const Point<Part> touching =
        field_ ? reference_on(contact_line(piece_, *field_, place, normal), place, normal)
               : place + normal * piece_.corner;
    return moves_.left(place, touching, enough);
  }

 private:
  static Point<Part> reference_on(const AxisLine& line, Point<Part>, Vec3) { return line.base; }

  std::shared_ptr<const PlanOptions> bare_;
  ToolPiece piece_;
  CuttingMoves moves_;
  std::optional<Deformation> field_;
};

}  // namespace

RestWanted::RestWanted(const CheckedMesh& part, const PlanOptions& options)
    : part_(part),
      options_(options),
      piece_(tool_pieces(*bare_options(options)).front()),
      stock_(part, options) {}

Result<RestWanted> RestWanted::find(const CheckedMesh& part, const PlanOptions& options,
                                    const ReportShare& report) {
  if (options.earlier.empty())
    return fail(
        Code::kInput,
        "rest.more_than_mm: there is no operation before this one that could leave anything; leave it "
        "out, or put the operation behind another");
  RestWanted found(part, options);
  if (auto done = found.look(report); !done) return tl::unexpected(done.error());
  return found;
}

Result<void> RestWanted::look(const ReportShare& report) {
  std::vector<std::unique_ptr<const LeftBy>> before;
  double smallest = piece_.outer;
  for (const auto& cut : options_.earlier) {
    before.push_back(std::make_unique<const LeftBy>(*cut));
    smallest = std::min(smallest, before.back()->farthest());
  }
  if (options_.rest_more_than >= smallest)
    return fail(Code::kInput, "rest.more_than_mm of " + number_text(options_.rest_more_than) +
                                  " is not below the smallest radius of the cutters that it is about, " +
                                  number_text(smallest) + " mm; use less");
  cell_ = std::max(kCellShare * smallest, options_.tolerance);
  std::optional<Deformation> field;
  if (options_.axis.mode != AxisMode::kIndexed) field.emplace(options_.axis, 1.0);
  const std::vector<SurfaceCell> all = make_cells(part_.mesh, cell_);
  const PatternKind kind = options_.pattern.kind;
  const bool walls =
      kind == PatternKind::kZLevel || kind == PatternKind::kSplit || kind == PatternKind::kPencil;
  const double facing = walls ? kWallFacing : kRestFacing;
  std::vector<double> left(all.size(), 0.0);
  Watch watch(report, all.size());
  tbb::parallel_for(std::size_t{0}, all.size(), [&](std::size_t i) {
    if (!watch.next()) return;
    const SurfaceCell& c = all[i];
    if (field && dot(field->axis_at(c.place), c.normal) < facing) return;
    double least = std::numeric_limits<double>::infinity();
    // The last one mostly leaves the least.
    for (auto by = before.rbegin(); by != before.rend(); ++by) {
      least = std::min(least, (*by)->at(c.place, c.normal, options_.rest_more_than));
      if (least <= options_.rest_more_than) return;
    }
    left[i] = least;
  });
  if (watch.stopped()) return cancelled();
  before_.more_than = options_.rest_more_than;
  for (std::size_t i = 0; i < all.size(); ++i) before_.most = std::max(before_.most, left[i]);
  reach_ = piece_.outer + std::max(options_.rest_more_than, kNearRest * piece_.outer);
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (left[i] == 0.0) continue;
    before_.area += all[i].area;
    const Point<Part> p = all[i].place;
    cells_[key(index(p.x), index(p.y), index(p.z))].push_back({p, left[i]});
  }
  const bool rough = options_.pattern.kind == PatternKind::kRough;
  if (rough) stock_.lay_grid();
  if (before_.area == 0.0 && !rough)
    return fail(Code::kUnreachable, "nowhere do the operations before leave more than rest.more_than_mm, " +
                                        number_text(options_.rest_more_than) +
                                        " mm, where this axis faces; leave the operation out, or use less");
  return {};
}

std::int64_t RestWanted::index(double v) const { return static_cast<std::int64_t>(std::floor(v / reach_)); }

std::uint64_t RestWanted::key(std::int64_t x, std::int64_t y, std::int64_t z) const {
  const auto part = [](std::int64_t v) {
    return static_cast<std::uint64_t>(v) & ((std::uint64_t{1} << kIndexBits) - 1);
  };
  return (part(x) << (2 * kIndexBits)) | (part(y) << kIndexBits) | part(z);
}

bool RestWanted::wants(Point<Part> reference, Vec3 axis) const {
  if (options_.pattern.kind == PatternKind::kRough)
    return stock_.meets(reference, axis, options_.pattern.step_down);
  const double gain = kGain * options_.rest_more_than,
               near = std::max(options_.rest_more_than, kNearRest * piece_.outer);
  const Point<Part> ring = reference + axis * piece_.above_reference;
  const auto x = index(ring.x), y = index(ring.y), z = index(ring.z);
  for (std::int64_t i = -1; i <= 1; ++i)
    for (std::int64_t j = -1; j <= 1; ++j)
      for (std::int64_t k = -1; k <= 1; ++k) {
        const auto found = cells_.find(key(x + i, y + j, z + k));
        if (found == cells_.end()) continue;
        for (const Cell& cell : found->second) {
          const Vec3 w = cell.place - ring;
          const double h = dot(w, axis), d = std::sqrt(std::max(0.0, squared_length(w) - h * h));
          if (distance_to_piece(piece_, d, h) < std::min(near, cell.left - gain)) return true;
        }
      }
  return false;
}

}  // namespace tiltfeed::pathgen
