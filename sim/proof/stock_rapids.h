#pragma once
// Rapids of a program against the stock that its operations before have left. (P6) in sim/proof/README.md.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "config/job.h"
#include "kinematics/basics/result.h"
#include "pathgen/mesh/mesh_check.h"
#include "sim/removal/removal_result.h"
#include "sim/removal/stock.h"

namespace tiltfeed::sim {

struct RapidInStock {
  std::size_t operation = 0;  ///< which of them
  Trouble worst;              ///< the deepest of its first operation with any
  StockShape stock;           ///< from which the program begins
};

/// The program at `path` cuts the blank, or what `verify` takes where nobody states one, by its operations in
/// order, up to the last that roughs; with a blank, by the first one at least. Nothing where no rapid runs
/// deeper into stock than half of a line's distance and the tolerance, where no operation is asked, or where
/// the first of `operations` is not the job's first: then nobody knows the stock. `part`: of the first
/// operation. Errors: as read_moves() and make_stock(); kCancelled.
Result<std::optional<RapidInStock>> find_rapid_in_stock(const std::string& path,
                                                        const std::vector<config::Job>& operations,
                                                        const pathgen::CheckedMesh& part, int threads,
                                                        const std::function<bool(double)>& go_on);

}  // namespace tiltfeed::sim
