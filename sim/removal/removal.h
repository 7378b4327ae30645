#pragma once
// Verification by material removal: the machine's moves against stock and part. What must hold is in
// sim/removal/README.md, "Material removal".

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "config/job.h"
#include "kinematics/basics/result.h"
#include "sim/removal/executed_path.h"
#include "sim/removal/probes.h"
#include "sim/removal/removal_result.h"
#include "sim/removal/rest.h"
#include "sim/removal/stock.h"
#include "sim/removal/stock_film.h"

namespace tiltfeed::sim {

/// Cuts `stock` by the path. `film`: goes on with it.
/// Properties: 1 Whatever the resolution, a gouge is found and its depth told, a ball's to 1e-3 mm; the
/// deepest is located even if it is tolerated. 2 New ends of the stock's lines are within 2 kDexelUnit of a
/// straight cut's surface; where the tool turns, within an eighth of a cell or half the tolerance, and
/// 1e-3 mm. 3 A probe keeps the least that any move left there, whatever their order. 4 The result is the
/// same for any number of threads. 5 The film begins with the stock and ends with what is left.
/// Errors: kCancelled.
Result<Removal> remove_material(const config::Job& job, const ExecutedPath& path, Stock& stock,
                                Probes& probes, const RemovalOptions& options,
                                const pathgen::Progress& progress, StockFilm* film = nullptr);

/// Upper limit of measured rest material, mm; larger values saturate. It is over `rest_limit`, so that what
/// saturates is more than may be left.
double probe_reach(const config::Job& job, double rest_limit = 0.0);

}  // namespace tiltfeed::sim
