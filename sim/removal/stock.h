#pragma once
// The stock: what a part is cut from, as three bundles of dexels.

#include <array>
#include <string>
#include <vector>

#include "config/job.h"
#include "kinematics/basics/result.h"
#include "pathgen/mesh/mesh.h"
#include "sim/removal/dexels.h"

namespace tiltfeed::sim {

enum class StockKind {
  kOffset,    ///< the part and everything within `margin` of it
  kBox,       ///< the part's box along the part's axes, `margin` larger on every side
  kCylinder,  ///< round about the table's direction through the middle of the part's box, `margin` larger
  kFile       ///< an STL in the part's coordinates and unit
};

struct StockShape {
  StockKind kind = StockKind::kOffset;
  double margin = 0.0;  ///< mm
  std::string path;
  double unit_mm = 0.0;  ///< of the file; 0: the part's
};

/// "offset:MM", "box", "box:MM", "cylinder", "cylinder:MM", or the path of an STL file.
/// Errors: kUsage.
Result<StockShape> parse_stock(const std::string& text);
/// What a job is cut from without --stock: its blank. Where it states none, and of a later operation, the
/// part with half the length that the job approaches at plunge feed, so that its rapids may end where they
/// do; for a roughing pattern the part's box.
StockShape default_stock(const config::Job& job);
std::string to_string(const StockShape& shape);
/// The distance of its lines where nobody states one, mm: a tenth of the cutter, more for a large part.
double default_cell(const config::Job& job, const pathgen::CheckedMesh& part);

struct Stock {
  std::vector<Dexels> bundles;  ///< along some of x, y, z
  pathgen::Box box;
  double cell = 0.0;  ///< distance of neighbouring lines, mm

  double volume() const;  ///< mean of the bundles, mm^3
  std::size_t bytes() const;
};

/// What the lines of such a stock need, and what is free now, bytes.
std::uint64_t stock_bytes(const pathgen::Box& box, double cell, const std::vector<int>& axes);
std::uint64_t free_bytes();

/// `axes`: which bundles (0 x, 1 y, 2 z). One holds walls along its lines to half a cell and everything else
/// exactly; three hold everything to a small part of a cell.
/// Errors: kMesh: part or stock is not closed; kInput: the stock does not hold the part (most missing,
/// where); kLimit: memory, with the resolution that would do; kIo.
Result<Stock> make_stock(const StockShape& shape, const pathgen::CheckedMesh& part, const config::Job& job,
                         double cell, int threads, const std::vector<int>& axes = {0, 1, 2});

}  // namespace tiltfeed::sim
