#include "sim/proof/stock_rapids.h"

#include <algorithm>

#include "sim/removal/removal.h"
#include "sim/report/verified_moves.h"

namespace tiltfeed::sim {
namespace {

/// Lines of the stock stand at so much of the distance that `verify` takes for the coarsest of the
/// operations.
constexpr double kLineShare = 0.5;
/// Of the part no distance is asked here: as few probes as there can be, mm.
constexpr double kProbesApart = 1e3;

bool is_rough(const config::Job& job) { return job.plan.pattern.kind == pathgen::PatternKind::kRough; }

}  // namespace

Result<std::optional<RapidInStock>> find_rapid_in_stock(const std::string& path,
                                                        const std::vector<config::Job>& operations,
                                                        const pathgen::CheckedMesh& part, int threads,
                                                        const std::function<bool(double)>& go_on) {
  const config::Job& first = operations.front();
  const auto last = std::find_if(operations.rbegin(), operations.rend(), is_rough);
  const std::size_t asked =
      std::max<std::size_t>(static_cast<std::size_t>(operations.rend() - last), first.blank ? 1 : 0);
  const StockShape shape = default_stock(first);
  const bool known = shape.kind != StockKind::kOffset || part.sides == pathgen::Sides::kOutward;
  if (asked == 0 || first.operation.number != 1 || !known) return std::optional<RapidInStock>();
  const auto moves = read_moves({Source::kProgram, path}, operations);
  if (!moves) return tl::unexpected(moves.error());
  double cell = 0.0;
  for (std::size_t i = 0; i < asked; ++i)
    cell = std::max(cell, kLineShare * default_cell(operations[i], part));
  // One bundle does where all of them cut along it.
  const auto along = [&](std::size_t i) {
    return main_direction(moves->paths[i], operations[i].machine.model, operations[i].setup);
  };
  bool one = true;
  for (std::size_t i = 1; i < asked; ++i) one = one && along(i) == along(0);
  auto stock = make_stock(shape, part, first, cell, threads,
                          one ? std::vector<int>{along(0)} : std::vector<int>{0, 1, 2});
  if (!stock) return tl::unexpected(stock.error());
  for (std::size_t i = 0; i < asked; ++i) {
    if (moves->paths[i].moves.empty()) continue;
    Probes probes(part.mesh, kProbesApart, probe_reach(operations[i]));
    const RemovalOptions options{
        .tolerance = operations[i].plan.tolerance, .threads = threads, .stock_alone = true};
    const auto cut = remove_material(
        operations[i], moves->paths[i], *stock, probes, options, [&](const char*, double share) {
          return go_on((static_cast<double>(i) + share) / static_cast<double>(asked));
        });
    if (!cut) return tl::unexpected(cut.error());
    for (const Trouble& trouble : cut->troubles)
      if (trouble.kind == TroubleKind::kRapidStock) return std::optional(RapidInStock{i, trouble, shape});
  }
  return std::optional<RapidInStock>();
}

}  // namespace tiltfeed::sim
